#include "abbe/machine/profile_sections.h"

#include <fmt/format.h>

#include <utility>

namespace abbe {

Section::Section(const TomlNode& root, std::string name, const std::vector<std::string>& keys,
                 Findings& findings)
    : name_(std::move(name)), findings_(findings) {
  const TomlEntry* entry = root.find(name_);
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, name_, findings)) return;
  table_ = &entry->value;
  refuse_other_keys(*table_, keys, "[" + name_ + "]", findings);
}

const TomlNode* Section::find(std::string_view key) const {
  const TomlEntry* entry = table_ == nullptr ? nullptr : table_->find(key);
  return entry == nullptr ? nullptr : &entry->value;
}

std::string Section::what(std::string_view key) const { return fmt::format("{}.{}", name_, key); }

void Section::flag(std::string_view key, bool& value) const {
  if (const TomlNode* node = find(key)) value = read_flag(*node, what(key), findings_).value_or(value);
}

void Section::choice(std::string_view key, const char* yes, const char* no, bool& value) const {
  if (const TomlNode* node = find(key)) {
    if (const auto at = read_choice(*node, {yes, no}, what(key), findings_)) value = *at == 0;
  }
}

void Section::positive(std::string_view key, double& value) const {
  const TomlNode* node = find(key);
  const auto number = node == nullptr ? std::nullopt : read_value(*node, what(key), findings_);
  if (!number) return;
  if (*number > 0) {
    value = *number;
  } else {
    findings_.error("E-VALUE", node->mark, fmt::format("{} is not positive", what(key)), "",
                    "write a positive number");
  }
}

std::optional<int> Section::whole_number(const TomlNode& node, const std::string& name, int low,
                                         int high) const {
  if (!expect_kind(node, TomlNode::Kind::number, name, findings_)) return std::nullopt;
  if (node.is_integer && node.integer >= low && node.integer <= high) return static_cast<int>(node.integer);
  findings_.error("E-VALUE", node.mark,
                  fmt::format("{} is not a whole number from {} to {}", name, low, high), "",
                  "correct the number");
  return std::nullopt;
}

std::vector<std::string> Section::texts(std::string_view key) const {
  std::vector<std::string> list;
  const TomlNode* node = find(key);
  if (node == nullptr || !expect_kind(*node, TomlNode::Kind::array, what(key), findings_)) return list;
  for (const TomlNode& item : node->items) {
    if (auto text = read_text(item, what(key), findings_)) list.push_back(std::move(*text));
  }
  return list;
}

}  // namespace abbe
