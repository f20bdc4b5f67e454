#include <openssl/evp.h>

#include <array>
#include <new>

#include "abbe/core/file.h"

namespace abbe {

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  std::string digits;  // once finished

  State() {
    if (context == nullptr || EVP_DigestInit_ex(context, EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
  }
  ~State() { EVP_MD_CTX_free(context); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Sha256::Sha256() : state_(std::make_unique<State>()) {}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::string_view bytes) {
  if (state_->digits.empty()) EVP_DigestUpdate(state_->context, bytes.data(), bytes.size());
}

std::string Sha256::hex() {
  if (state_->digits.empty()) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned int length = 0;
    EVP_DigestFinal_ex(state_->context, digest.data(), &length);
    for (unsigned int i = 0; i < length; ++i) {
      state_->digits += "0123456789abcdef"[digest[i] >> 4];
      state_->digits += "0123456789abcdef"[digest[i] & 15U];
    }
  }
  return state_->digits;
}

}  // namespace abbe
