#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"

namespace CLI {  // NOLINT(readability-identifier-naming): its name
class App;
class Option;
}  // namespace CLI

// Options and verbs of a program. CLI11 reads them and writes the help; its headers, which take seconds to compile, are
// included in one file only.
namespace haptics {

/// What is done with a text that was given: it is checked, or taken. Refused: what is wrong with it, for the person who
/// gave it.
using TextTaker = std::function<Result<void>(const std::string&)>;

/// An option, a flag or a positional argument. A handle: it is valid as long as its CommandLine, and a copy is the same
/// option.
class Option {
 public:
  /// What stands for the value in the help, such as FILE.
  Option typeName(const std::string& text);
  Option required();
  /// The help says the default: what the variable holds now, or `text`.
  Option showDefault();
  Option showDefault(const std::string& text);
  Option hidden();

  /// Ends included.
  Option range(double least, double most);
  Option range(int least, int most);
  Option range(std::size_t least, std::size_t most);
  Option moreThanZero();
  Option zeroOrMore();
  Option existingFile();
  Option existingFolder();
  /// Of a file that is written: checkEnding().
  Option ending(const std::string& ending);
  Option oneOf(const std::vector<std::string>& words);
  /// @param shown  In the help, after the type's name.
  Option check(const TextTaker& check, const std::string& shown = "");

  Option needs(const Option& other);
  /// Neither is given together with the other.
  Option excludes(const Option& other);
  /// Of a list: it is given so many times, with one value each.
  Option atMost(std::size_t times);

  [[nodiscard]] bool given() const;

 private:
  friend class Command;
  explicit Option(CLI::Option* option) : option_(option) {}
  CLI::Option* option_;
};

/// A program, or one of its verbs. A handle, as Option is.
class Command {
 public:
  /// `value` keeps what it holds where the option is not given, and outlives the parsing. Its type is one of those that
  /// command_line.cpp lists.
  /// @param name  Such as --rate; with commas between several; of a positional argument without dashes.
  template <class Value>
  Option option(const std::string& name, Value& value, const std::string& about = "");
  /// @param name  With ! before it: the flag sets `value` to false.
  Option flag(const std::string& name, bool& value, const std::string& about = "");
  Option option(const std::string& name, const TextTaker& take, const std::string& about);
  /// The same of an option that may be given more than once, for each value.
  Option list(const std::string& name, const TextTaker& take, const std::string& about);
  template <class Enum>
  Option choice(const std::string& name, Enum& value, const std::map<std::string, Enum>& byName,
                const std::string& about) {
    std::map<std::string, int> numbers;
    for (const auto& [word, meant] : byName) numbers.emplace(word, static_cast<int>(meant));
    return choice(
        name, [&value](int number) { value = static_cast<Enum>(number); }, numbers, about);
  }
  /// A flag that does something, in place of what the program does else: it ends well.
  Option action(const std::string& name, const std::function<void()>& act, const std::string& about);

  Command verb(const std::string& name, const std::string& about = "");
  /// Exactly one of its verbs has to be given.
  void needVerb();
  /// Verbs that are added from now on leave options that they do not know to this one.
  void takeOptionsAfterVerbs();
  /// Below the options in the help.
  Command footer(const std::string& text);
  /// The help of the program leaves the verb out.
  Command hidden();
  /// Runs as soon as the verb's own options are read, when what comes after them may still be refused.
  void whenRead(const std::function<void()>& run);
  /// Runs where the verb is given and nothing was wrong. Refused: what is wrong after all.
  void then(const std::function<Result<void>()>& run);

  [[nodiscard]] bool given() const;
  [[nodiscard]] std::vector<std::string> verbs() const;  ///< Names, in the order in which they were added.

 protected:
  explicit Command(CLI::App* app) : app_(app) {}
  CLI::App* app_;

 private:
  Option choice(const std::string& name, const std::function<void(int)>& take, const std::map<std::string, int>& byName,
                const std::string& about);
};

/// A program's command line; it has --help.
class CommandLine : public Command {
 public:
  /// @param name  Empty: that by which the program is called.
  explicit CommandLine(const std::string& about = "", const std::string& name = "");
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// With --version, which prints it.
  void version(const std::string& text);

  /// @return The exit code where the program is to leave: 0 after --help and the like; above 100 where something is wrong.
  /// Either was printed. Exceptions of what is run pass through.
  [[nodiscard]] std::optional<int> parse(int argc, const char* const* argv);
  /// Without the program's name; prints nothing.
  [[nodiscard]] Result<void> parse(const std::vector<std::string>& arguments);

 private:
  std::unique_ptr<CLI::App> owned_;
};

}  // namespace haptics
