#include "common/command_line/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "common/process/pending_file.h"

namespace haptics {
namespace {

void throwRefusal(const std::string& of, const Result<void>& result) {
  if (!result) throw CLI::ValidationError(of, result.error().text());
}

}  // namespace

Option Option::typeName(const std::string& text) { return Option(option_->type_name(text)); }
Option Option::required() { return Option(option_->required()); }
Option Option::showDefault() { return Option(option_->capture_default_str()); }
Option Option::showDefault(const std::string& text) { return Option(option_->default_str(text)); }
Option Option::hidden() { return Option(option_->group("")); }

Option Option::range(double least, double most) { return Option(option_->check(CLI::Range(least, most))); }
Option Option::range(int least, int most) { return Option(option_->check(CLI::Range(least, most))); }
Option Option::range(std::size_t least, std::size_t most) { return Option(option_->check(CLI::Range(least, most))); }
Option Option::moreThanZero() { return Option(option_->check(CLI::PositiveNumber)); }
Option Option::zeroOrMore() { return Option(option_->check(CLI::NonNegativeNumber)); }
Option Option::existingFile() { return Option(option_->check(CLI::ExistingFile)); }
Option Option::existingFolder() { return Option(option_->check(CLI::ExistingDirectory)); }
Option Option::ending(const std::string& ending) {
  return check([ending](const std::string& file) { return checkEnding(file, ending); });
}
Option Option::oneOf(const std::vector<std::string>& words) { return Option(option_->check(CLI::IsMember(words))); }
Option Option::check(const TextTaker& check, const std::string& shown) {
  const auto whatIsWrong = [check](const std::string& text) {
    const Result<void> checked = check(text);
    return checked ? std::string() : checked.error().text();
  };
  return Option(option_->check(CLI::Validator(whatIsWrong, shown)));
}

Option Option::needs(const Option& other) { return Option(option_->needs(other.option_)); }
Option Option::excludes(const Option& other) { return Option(option_->excludes(other.option_)); }
Option Option::atMost(std::size_t times) {
  return Option(option_->expected(1, static_cast<int>(times))->allow_extra_args(false));
}

bool Option::given() const { return option_->count() > 0; }

template <class Value>
Option Command::option(const std::string& name, Value& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::int64_t&, const std::string&);
template Option Command::option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, std::filesystem::path&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);

Option Command::flag(const std::string& name, bool& value, const std::string& about) {
  return Option(app_->add_flag(name, value, about));
}

Option Command::option(const std::string& name, const TextTaker& take, const std::string& about) {
  const std::function<void(const std::string&)> taken = [name, take](const std::string& text) {
    throwRefusal(name, take(text));
  };
  return Option(app_->add_option_function(name, taken, about));
}

Option Command::list(const std::string& name, const TextTaker& take, const std::string& about) {
  const std::function<void(const std::vector<std::string>&)> taken = [name, take](const auto& texts) {
    for (const std::string& text : texts) throwRefusal(name, take(text));
  };
  return Option(app_->add_option_function(name, taken, about));
}

Option Command::choice(const std::string& name, const std::function<void(int)>& take,
                       const std::map<std::string, int>& byName, const std::string& about) {
  return Option(app_->add_option_function<int>(
                        name, [take](const int& number) { take(number); }, about)
                    ->transform(CLI::CheckedTransformer(byName).description("")));
}

Option Command::action(const std::string& name, const std::function<void()>& act, const std::string& about) {
  const auto actAndEnd = [act] {
    act();
    throw CLI::Success();
  };
  return Option(app_->add_flag_callback(name, actAndEnd, about));
}

Command Command::verb(const std::string& name, const std::string& about) {
  return Command(app_->add_subcommand(name, about));
}
void Command::needVerb() { app_->require_subcommand(1); }
void Command::takeOptionsAfterVerbs() { app_->fallthrough(); }
Command Command::footer(const std::string& text) { return Command(app_->footer(text)); }
Command Command::hidden() { return Command(app_->group("")); }
void Command::whenRead(const std::function<void()>& run) { app_->parse_complete_callback(run); }
void Command::then(const std::function<Result<void>()>& run) {
  app_->callback([run] {
    if (const Result<void> done = run(); !done) throw CLI::ValidationError(done.error().text());
  });
}

bool Command::given() const { return app_->parsed(); }

std::vector<std::string> Command::verbs() const {
  std::vector<std::string> names;
  for (const CLI::App* verb : app_->get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

CommandLine::CommandLine(const std::string& about, const std::string& name)
    : Command(new CLI::App(about, name)), owned_(app_) {}
CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& text) { app_->set_version_flag("--version", text); }

std::optional<int> CommandLine::parse(int argc, const char* const* argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::RequiredError& error) {
    const std::vector<std::string> unknown = app_->remaining();
    if (unknown.empty() || app_->get_require_subcommand_min() == 0 || !app_->get_subcommands().empty())
      return app_->exit(error);
    std::string all;
    for (const std::string& verb : verbs()) all += (all.empty() ? "" : ", ") + verb;
    return app_->exit(
        CLI::ParseError("there is no verb \"" + unknown.front() + "\"; one of: " + all, CLI::ExitCodes::RequiredError));
  } catch (const CLI::ParseError& error) {
    return app_->exit(error);
  }
  return std::nullopt;
}

Result<void> CommandLine::parse(const std::vector<std::string>& arguments) {
  try {
    app_->parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // from its end, as CLI11 takes it
  } catch (const CLI::Error& error) {
    return refused("", error.what());
  }
  return {};
}

}  // namespace haptics
