#include <cstdio>
#include <string>

#include "inhabit/error.h"
#include "inhabit/math/simd.h"
#include "verbs.h"

namespace {

// First line only: LibTorch appends a stack trace to its messages.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// Where a verb is missing or wrong: what was said, and what may be.
std::string without_verb(const CLI::App& app) {
  const CLI::App* last = &app;
  while (!last->get_subcommands().empty()) last = last->get_subcommands().front();
  std::string verbs;
  for (const CLI::App* verb : last->get_subcommands([](const CLI::App*) { return true; }))
    verbs += (verbs.empty() ? "" : ", ") + verb->get_name();
  const std::vector<std::string> unknown = app.remaining(true);
  return (unknown.empty() ? "a verb is missing" : unknown.front() + ": is no verb") + "; there are " + verbs;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"inhabit: human motion in 3D scenes"};
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
  add_intentions(app);
  add_info(app);
  add_view(app);
  add_synth(app);
  add_score(app);
  add_average(app);
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
    return e.get_exit_code();
  } catch (const CLI::RequiredError& e) {
    const bool no_verb = first_line(e.what()) == CLI::RequiredError::Subcommand(1).what();
    std::fprintf(stderr, "inhabit: %s\n", no_verb ? without_verb(app).c_str() : first_line(e.what()).c_str());
    return 2;
  } catch (const CLI::ParseError& e) {
    std::fprintf(stderr, "inhabit: %s\n", first_line(e.what()).c_str());
    return 2;
  } catch (const inhabit::Error& e) {
    std::fprintf(stderr, "inhabit: %s\n", first_line(e.what()).c_str());
    return 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "inhabit: out of memory\n");
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "inhabit: unexpected: %s\n", first_line(e.what()).c_str());
    return 3;
  }
  return 0;
}
