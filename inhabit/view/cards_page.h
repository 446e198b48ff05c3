#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/view/page.h"

namespace inhabit {

/// Curves over a number, or bars: what a training log or an evaluation's table holds, as charts.
struct PageChart {
  struct Series {
    std::string name;
    std::vector<double> x;         ///< where the panel has no ticks
    std::vector<double> y;         ///< one for each x or tick; NaN: none
    std::vector<double> interval;  ///< half of the 95 % confidence interval, one for each y; empty: not known
  };
  struct Panel {
    std::string title;
    std::string group;               ///< panels of one group are seen together; empty: there is but one
    std::vector<std::string> ticks;  ///< names along x
    bool bars = false;               ///< else curves
    std::vector<Series> series;
  };
  std::string x;  ///< what runs along x: "step"
  std::vector<Panel> panels;
};

/// One file of a page of many: a card with a moving thumbnail or a picture, which opens in 3D, or charts.
struct PageCard {
  std::string name, note;
  std::optional<PagePerson> person;    ///< shown as a figure: its joints to a millimetre
  std::shared_ptr<const Scene> scene;  ///< may be shared by cards; nullptr: none
  std::optional<PageChart> chart;
};

/// A page of many files.
struct CardsPage {
  std::string title, note;
  std::vector<PageCard> cards;
};

/// Writes a page of cards as write_page writes one of people: one file, no network. Positions of scenes are kept to
/// 1/65535 of their extent, scenes beyond 20,000 triangles or 10,000 points thinned. Throws Error(path, ...) where
/// there is no card, or a clip, scene or chart is inconsistent or not finite, or the file cannot be written.
void write_page(const std::string& path, const CardsPage& page);

/// Writes a page that shows nothing yet: motions and scenes are dropped on it. It carries the built-in body for them.
void write_empty_page(const std::string& path, const std::string& title, const std::string& note = "");

}  // namespace inhabit
