#include <fcntl.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <utility>

#include "common/credentials/credentials.h"
#include "common/credentials/openssl_handles.h"

namespace haptics {
namespace {

namespace fs = std::filesystem;

using openssl::Bio, openssl::Certificate, openssl::Key;
using Extension = Handle<X509_EXTENSION, &X509_EXTENSION_free>;

/// Begins a day before now: the clocks of two machines differ. Ends when nobody uses this server any more; a stolen
/// key is answered by making new credentials, not by waiting.
constexpr long kValidBefore_s = 24L * 3600, kValidAfter_s = 10L * 365 * 24 * 3600;
constexpr int kSerialBits = 64;

void require(bool worked) {
  if (!worked) throw std::runtime_error("the system's libcrypto cannot make a certificate");
}

Certificate selfSigned(EVP_PKEY* key) {
  Certificate certificate(X509_new());
  X509* x = certificate.get();
  require(x != nullptr && X509_set_version(x, X509_VERSION_3) == 1);
  const Handle<BIGNUM, &BN_free> serial(BN_new());
  require(BN_rand(serial.get(), kSerialBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1);
  require(BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(x)) != nullptr);
  require(X509_gmtime_adj(X509_getm_notBefore(x), -kValidBefore_s) != nullptr);
  require(X509_gmtime_adj(X509_getm_notAfter(x), kValidAfter_s) != nullptr);
  X509_NAME* name = X509_get_subject_name(x);
  const auto* text = reinterpret_cast<const unsigned char*>(kServerName);
  require(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8, text, -1, -1, 0) == 1);
  require(X509_set_issuer_name(x, name) == 1 && X509_set_pubkey(x, key) == 1);
  const std::string alternative = std::string("DNS:") + kServerName;
  // It signs nothing but itself: whoever holds the key can be this server, and cannot make another one trusted.
  for (const auto& [kind, value] :
       std::initializer_list<std::pair<int, const char*>>{{NID_basic_constraints, "critical,CA:FALSE"},
                                                          {NID_key_usage, "critical,digitalSignature"},
                                                          {NID_ext_key_usage, "serverAuth"},
                                                          {NID_subject_alt_name, alternative.c_str()}}) {
    const Extension extension(X509V3_EXT_conf_nid(nullptr, nullptr, kind, value));
    require(extension && X509_add_ext(x, extension.get(), -1) == 1);
  }
  require(X509_sign(x, key, EVP_sha256()) > 0);
  return certificate;
}

template <class Write>
std::string pem(Write write) {
  const Bio out(BIO_new(BIO_s_mem()));
  require(out && write(out.get()) == 1);
  char* data = nullptr;
  const long size = BIO_get_mem_data(out.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

std::string randomToken() {
  std::array<unsigned char, kTokenBytes> bytes{};
  require(RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) == 1);
  return {bytes.begin(), bytes.end()};
}

std::string clientFile(Role role, const std::string& token, const std::string& certificatePem) {
  return "# For clients of a haptic_server; role: " + std::string(nameOf(role)) +
         ". Keep it to those who may have that role.\ntoken: " + ContentHash::fromBytes(token).value().hex() + "\n" +
         certificatePem;
}

Result<void> writeNew(const fs::path& file, const std::string& content) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (descriptor < 0 && errno == EEXIST)
    return refused(file.string(), "exists and is not replaced; choose a new folder");
  if (descriptor < 0) return refused(file.string(), std::strerror(errno));
  const bool isComplete = ::write(descriptor, content.data(), content.size()) == static_cast<ssize_t>(content.size()) &&
                          ::fsync(descriptor) == 0;
  const bool closed = ::close(descriptor) == 0;
  if (isComplete && closed) return {};
  ::unlink(file.c_str());
  return refused(file.string(), "cannot be written: is the disk full?");
}

/// The key comes last: a folder with it has all, one without it was not finished.
Result<void> checkIsNew(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / kServerKeyFile, error))
    return refused((folder / kServerKeyFile).string(), "exists and is not replaced; choose a new folder");
  std::string left;
  for (const char* const name : {kViewerFile, kEditorFile, kTokensFile, kServerCertificateFile}) {
    if (fs::exists(folder / name, error)) left += (left.empty() ? "" : ", ") + std::string(name);
  }
  if (left.empty()) return {};
  return refused(folder.string(), "holds " + left + " and no " + kServerKeyFile +
                                      ": remove them if a run that did not finish left them, or choose a new folder");
}

}  // namespace

Result<void> makeCredentials(const fs::path& folder) {
  if (auto isNew = checkIsNew(folder); !isNew) return isNew;
  const Key key(EVP_EC_gen("P-256"));
  require(key != nullptr);
  const Certificate certificate = selfSigned(key.get());
  const std::string certificatePem = pem([&](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); });
  const std::string keyPem =
      pem([&](BIO* out) { return PEM_write_bio_PrivateKey(out, key.get(), nullptr, nullptr, 0, nullptr, nullptr); });
  const std::string view = randomToken(), edit = randomToken();

  std::error_code error;
  if (fs::create_directories(folder, error); error) return refused(folder.string(), error.message());
  const std::string tokens =
      "# role and SHA-256 of each token that is accepted; a line less is a token withdrawn\nview " +
      hashOfToken(view).hex() + "\nedit " + hashOfToken(edit).hex() + "\n";
  const std::array<std::pair<const char*, std::string>, 5> files{
      {{kViewerFile, clientFile(Role::kView, view, certificatePem)},
       {kEditorFile, clientFile(Role::kEdit, edit, certificatePem)},
       {kTokensFile, tokens},
       {kServerCertificateFile, certificatePem},
       {kServerKeyFile, keyPem}}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto written = writeNew(folder / files[i].first, files[i].second);
    if (written) continue;
    while (i-- > 0) fs::remove(folder / files[i].first, error);
    return written;
  }
  return {};
}

}  // namespace haptics
