#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "common/credentials/token_list.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// Who may connect, as what, and how many. One thread.
class Admission {
 public:
  static constexpr std::size_t kMaxClients = 64;
  /// Limits within these for viewers and for clients with one token: whoever holds a token leaves room for others.
  static constexpr std::size_t kMaxViewers = 48;
  static constexpr std::size_t kMaxClientsOfToken = 48;
  /// Memory for uploads under way, being built and waiting for an edit, of all clients and of those with one token.
  static constexpr std::size_t kUploads_bytes = 512U << 20;
  static constexpr std::size_t kUploadsOfToken_bytes = 384U << 20;

  struct Client {
    SessionId session = 0;
    Role role = Role::kView;
    ContentHash token = {};  ///< hashOfToken().
  };

  /// Without credentials no token is asked for and everybody may edit.
  explicit Admission(const std::optional<ServerCredentials>& credentials);

  /// @param others  Welcomed clients; one of this session with the same token is about to be replaced.
  /// @return The role; or the field of Hello and the reason for which the client is refused.
  [[nodiscard]] Result<Role> admit(SessionId session, const std::string& token, std::span<const Client> others) const;
  /// The session that a client's edits count for: nobody with another token resends them or gets their answers.
  [[nodiscard]] SessionId editSession(const Client& client) const;
  [[nodiscard]] std::size_t uploadsOfToken_bytes() const noexcept {
    return tokens_ ? kUploadsOfToken_bytes : kUploads_bytes;
  }

  [[nodiscard]] Result<bool> refresh(bool anyway);  ///< TokenList::refresh(); false without credentials.
  /// Refused: the token was withdrawn, or has another role now.
  [[nodiscard]] Result<void> check(const Client& client) const;

 private:
  std::optional<TokenList> tokens_;
};

}  // namespace haptics
