#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "abbe/machine/profile.h"
#include "abbe/program/block.h"
#include "abbe/program/klartext_block.h"

namespace abbe {

constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }

/// What reading any block of a conversational program needs: the place in its line, numbers, coordinates, the
/// words that they become, and why something is no word. The reader of the blocks (read_klartext_block) is
/// made of it.
class KlartextScan {
 public:
  KlartextScan(const Profile& profile, KlartextContext& context, Block& block)
      : profile_(profile), context_(context), block_(block), text_(block.text) {}

 protected:
  /// What stands behind ';' is a comment, a '~' at the end says that the block goes on.
  void take_tail();
  void skip_blanks();
  std::string_view name();
  std::optional<BlockError> copied();
  /// What stands in the block from at_ on, its blanks made one.
  [[nodiscard]] std::string rest() const;
  /// The word at `begin` is not one of ours: what the profile says of it.
  [[nodiscard]] BlockError strange(std::size_t begin, std::size_t length) const;
  [[nodiscard]] BlockError refused(const Profile::Keyword& keyword, std::size_t begin,
                                   std::size_t length) const;
  [[nodiscard]] BlockError wrong(const char* code, std::size_t begin, std::string message, const char* why,
                                 const char* fix) const;
  std::optional<BlockError> add(char letter, std::size_t begin, std::size_t number, std::size_t end,
                                double value, int decimals = 0);
  std::optional<BlockError> add_code(const Profile::Keyword& keyword, std::size_t begin, std::size_t end);
  /// "+10.5", "-0,25": the comma counts as a point. The number begins at or behind at_.
  std::optional<BlockError> read_value(char letter, std::size_t begin);
  /// X Y Z A B C, with I before X Y Z. False: something else stands here.
  bool read_coordinate(std::optional<BlockError>& error);
  std::optional<BlockError> read_coordinates();

  const Profile& profile_;
  KlartextContext& context_;
  Block& block_;
  std::string_view text_;
  std::size_t at_ = 0, end_ = 0;  ///< the place in the line, and where its words end
};

}  // namespace abbe
