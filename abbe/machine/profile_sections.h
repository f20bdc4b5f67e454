#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/machine/profile.h"
#include "abbe/machine/toml_values.h"

// What the files that read a profile share; not for others.

namespace abbe {

inline constexpr int kMostFurtherOffsets = 300;
inline constexpr int kFixedOffsets = 9;

/// One table of a profile: what it names is changed, the rest stays. Mistakes are findings.
class Section {
 public:
  Section(const TomlNode& root, std::string name, const std::vector<std::string>& keys, Findings& findings);

  [[nodiscard]] const TomlNode* find(std::string_view key) const;
  [[nodiscard]] std::string what(std::string_view key) const;  ///< "numbers.digits"

  void flag(std::string_view key, bool& value) const;
  /// A flag that reads better as one of two words.
  void choice(std::string_view key, const char* yes, const char* no, bool& value) const;
  template <class Enum>
  void choice(std::string_view key, const std::vector<std::string>& words, Enum& value) const {
    if (const TomlNode* node = find(key)) {
      if (const auto at = read_choice(*node, words, what(key), findings_)) value = static_cast<Enum>(*at);
    }
  }
  void positive(std::string_view key, double& value) const;
  template <class Int>
  void whole(std::string_view key, Int& value, int low, int high) const {
    if (const TomlNode* node = find(key)) read_whole(*node, what(key), value, low, high);
  }
  template <class Int>
  void read_whole(const TomlNode& node, const std::string& name, Int& value, int low, int high) const {
    if (const auto number = whole_number(node, name, low, high)) value = static_cast<Int>(*number);
  }
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;

 private:
  [[nodiscard]] std::optional<int> whole_number(const TomlNode& node, const std::string& name, int low,
                                                int high) const;

  std::string name_;
  Findings& findings_;
  const TomlNode* table_ = nullptr;
};

/// [codes], [addresses], [order] and [[refused]] of a profile; mistakes are findings.
void read_codes(const TomlNode& root, Profile& profile, Findings& findings);
void read_addresses(const TomlNode& root, Profile& profile, Findings& findings);
void read_order(const TomlNode& root, Profile& profile, Findings& findings);
void read_refusals(const TomlNode& root, Profile& profile, Findings& findings);

}  // namespace abbe
