#include "command_line.h"

#include <cstdio>
#include <string>

#include "inhabit/error.h"
#include "inhabit/math/simd.h"
#include "interrupted.h"
#include "progress.h"
#include "verbs.h"

namespace {

// First line only: LibTorch appends a stack trace to its messages.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// What is said of arguments that do not fit: of a verb or an option that there is none of first, for what else is
// missing may follow from it.
std::string refusal(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* last = &app;
  std::string path = app.get_name();
  while (!last->get_subcommands().empty()) {
    last = last->get_subcommands().front();
    path += " " + last->get_name();
  }
  const std::vector<std::string> left = app.remaining(true);
  const std::string said = first_line(error.what());
  if (said == CLI::RequiredError::Subcommand(1).what()) return no_verb(*last, left.empty() ? "" : left.front());
  for (const std::string& word : left)
    if (word.size() > 1 && word.front() == '-') return no_option(*last, path, word);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !left.empty())
    return no_option(*last, path, left.front());
  return said;
}

int refused(const std::string& text) {
  end_progress();
  std::fprintf(stderr, "inhabit: %s\n", text.c_str());
  return 2;
}

}  // namespace

int run_command_line(int argc, char** argv) {
  listen_for_interruptions();
  log_above_bars();
  CLI::App app{"Human motion in 3D scenes", "inhabit"};
  app.require_subcommand(1);
  add_version(app);
  add_forecast(app);
  add_inbetween(app);
  add_anticipate(app);
  add_interact(app);
  add_contacts(app);
  add_serve(app);
  add_stream(app);
  add_reconstruct(app);
  add_refine(app);
  add_train(app);
  add_eval(app);
  add_convert(app);
  add_import(app);
  add_intentions(app);
  add_info(app);
  add_view(app);
  add_synth(app);
  add_score(app);
  add_average(app);
  add_help(app);
  add_completion(app);
  add_quiet(app);
  add_examples(app);
  try {
    inhabit::simd_level();  // a wrong INHABIT_SIMD is said at once
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::RuntimeError& e) {  // a verb that has said what it found, as an exit code
    end_if_interrupted();
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {
    return refused(refusal(app, e));
  } catch (const inhabit::Error& e) {
    return refused(first_line(e.what()));
  } catch (const std::bad_alloc&) {
    return refused("out of memory");
  } catch (const std::exception& e) {
    end_progress();
    std::fprintf(stderr, "inhabit: unexpected: %s\n", first_line(e.what()).c_str());
    return 3;
  }
  return 0;
}
