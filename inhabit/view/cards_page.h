#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/view/page.h"

namespace inhabit {

/// Curves over a number, or bars: what a training log or an evaluation's table holds, as charts.
struct PageChart {
  /// A curve, or bars of one colour.
  struct Series {
    std::string name;              ///< in the legend
    std::vector<double> x;         ///< where the panel has no ticks
    std::vector<double> y;         ///< one for each x or tick; NaN: none
    std::vector<double> interval;  ///< half of the 95 % confidence interval, one for each y; empty: not known
  };
  /// What has one pair of axes.
  struct Panel {
    std::string title;               ///< above it
    std::string group;               ///< panels of one group are seen together; empty: there is but one
    std::vector<std::string> ticks;  ///< names along x
    bool bars = false;               ///< else curves
    std::vector<Series> series;      ///< drawn over each other, or side by side
  };
  std::string x;              ///< what runs along x: "step"
  std::vector<Panel> panels;  ///< one after the other
};

/// One file of a page of many: a card with a moving thumbnail or a picture, which opens in 3D, or charts.
struct PageCard {
  std::string name;                    ///< of the file
  std::string note;                    ///< a line below it
  std::optional<PagePerson> person;    ///< shown as a figure: its joints to a millimetre
  std::shared_ptr<const Scene> scene;  ///< may be shared by cards; nullptr: none
  std::optional<PageChart> chart;      ///< instead of a person or a scene
};

/// A page of many files.
struct CardsPage {
  std::string title;            ///< plain text
  std::string note;             ///< a caption below it
  std::vector<PageCard> cards;  ///< in this order
};

/// Writes a page of cards as write_page writes one of people: one file, no network. Positions of scenes are kept to
/// 1/65535 of their extent, scenes beyond 20,000 triangles or 10,000 points thinned. Throws Error(path, ...) where
/// there is no card, or a clip, scene or chart is inconsistent or not finite, or the file cannot be written.
void write_page(const std::string& path, const CardsPage& page);
/// The same as text. @param path named in errors
std::string page_text(const CardsPage& page, const std::string& path);

/// Writes a page that shows nothing yet: motions and scenes are dropped on it. It carries the built-in body for them.
void write_empty_page(const std::string& path, const std::string& title, const std::string& note = "");
/// The same as text.
std::string empty_page_text(const std::string& title, const std::string& note = "");

}  // namespace inhabit
