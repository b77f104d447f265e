#include "io/dds_security.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

namespace stillpoint::io {
namespace {

template <auto Free>
struct FreedBy {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, FreedBy<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, FreedBy<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, FreedBy<EVP_PKEY_free>>;
using Store = std::unique_ptr<X509_STORE, FreedBy<X509_STORE_free>>;
using StoreContext = std::unique_ptr<X509_STORE_CTX, FreedBy<X509_STORE_CTX_free>>;
using Signed = std::unique_ptr<PKCS7, FreedBy<PKCS7_free>>;
using Signers = std::unique_ptr<STACK_OF(X509), FreedBy<[](STACK_OF(X509) * all) { sk_X509_free(all); }>>;
using Faults = std::vector<std::string>;

Bio bio_of(const std::string& text) { return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))); }

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long n = BIO_get_mem_data(bio, &data);
  return n > 0 ? std::string(data, static_cast<std::size_t>(n)) : std::string();
}

/// The contents of the six files, by the member that names each.
struct Contents {
  const SecurityParams& paths;
  std::array<std::string, kSecurityFiles.size()> texts;

  [[nodiscard]] const std::string& operator()(std::string SecurityParams::*which) const {
    const auto* found = std::find_if(kSecurityFiles.begin(), kSecurityFiles.end(),
                                     [which](const SecurityFile& file) { return file.path == which; });
    return texts[static_cast<std::size_t>(found - kSecurityFiles.begin())];
  }
};

void read_all(Contents& contents, Faults& faults) {
  for (std::size_t k = 0; k < kSecurityFiles.size(); ++k) {
    const SecurityFile& file = kSecurityFiles[k];
    const std::string& path = contents.paths.*file.path;
    if (path.empty()) {
      faults.push_back(fmt::format("'{}' is missing: name its file, or a 'folder' that holds {}", file.key, file.name));
      continue;
    }
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    if (stream && text << stream.rdbuf() && !text.str().empty()) {
      contents.texts[k] = text.str();
      continue;
    }
    const int why = errno;
    const char* const advice = why == EACCES   ? "let the user that runs this read it (chgrp, chmod 640)"
                               : why == ENOENT ? "scripts/dds_keys.sh makes all six"
                                               : "name a file that holds it";
    faults.push_back(fmt::format("{}: {} cannot be read: {}; {}", file.key, path,
                                 why != 0 ? std::strerror(why) : "no file, or an empty one", advice));
  }
}

std::vector<Certificate> certificates(const std::string& text) {
  std::vector<Certificate> all;
  const Bio bio = bio_of(text);
  while (X509* one = PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr)) all.emplace_back(one);
  ERR_clear_error();  // the end of the file is one
  return all;
}

Key private_key(const std::string& text) {
  const auto no_passphrase = [](char*, int, int, void*) { return 0; };
  Key key(PEM_read_bio_PrivateKey(bio_of(text).get(), nullptr, no_passphrase, nullptr));
  ERR_clear_error();
  return key;
}

Store store_of(const std::vector<Certificate>& authorities) {
  Store store(X509_STORE_new());
  for (const auto& one : authorities) X509_STORE_add_cert(store.get(), one.get());
  return store;
}

/// Empty: the authority stands for the certificate, now.
std::string why_not_trusted(X509* certificate, const std::vector<Certificate>& authorities) {
  const Store store = store_of(authorities);
  const StoreContext context(X509_STORE_CTX_new());
  if (X509_STORE_CTX_init(context.get(), store.get(), certificate, nullptr) == 1 &&
      X509_verify_cert(context.get()) == 1)
    return {};
  ERR_clear_error();
  return X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
}

std::string subject_of(X509* certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(bio.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253 & ~ASN1_STRFLGS_ESC_MSB);
  return text_of(bio.get());
}

/// What was signed, as Fast DDS reads it; empty: not signed by these.
std::string signed_text(const std::string& document, const std::vector<Certificate>& authorities) {
  BIO* content = nullptr;
  const Signed envelope(SMIME_read_PKCS7(bio_of(document).get(), &content));
  const Bio inside(content), out(BIO_new(BIO_s_mem()));
  const Signers signers(sk_X509_new_null());
  for (const auto& one : authorities) sk_X509_push(signers.get(), one.get());
  const bool stands = envelope && PKCS7_verify(envelope.get(), signers.get(), nullptr, inside.get(), out.get(),
                                               PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN) == 1;
  ERR_clear_error();
  return stands ? text_of(out.get()) : std::string();
}

/// What the permissions say between the marks of a subject, each time.
std::vector<std::string> subjects_in(const std::string& permissions) {
  const std::string open = "<subject_name>", close = "</subject_name>";
  std::vector<std::string> all;
  for (std::size_t at = 0; (at = permissions.find(open, at)) != std::string::npos;) {
    at += open.size();
    const std::size_t end = permissions.find(close, at);
    if (end == std::string::npos) break;
    all.push_back(permissions.substr(at, end - at));
  }
  return all;
}

std::string without_spaces(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == ' ' || c == '\n' || c == '\t'; }),
             text.end());
  return text;
}

void check_identity(const Contents& read, X509* certificate, Faults& faults) {
  const auto& paths = read.paths;
  const Key key = private_key(read(&SecurityParams::private_key));
  if (!key)
    faults.push_back(
        fmt::format("private_key: {} holds no private key in PEM without a passphrase; "
                    "`openssl pkey -in KEY -out {}` takes one off",
                    paths.private_key, paths.private_key));
  else if (X509_check_private_key(certificate, key.get()) != 1)
    faults.push_back(fmt::format("private_key: {} does not belong to the certificate {}; name the two of one folder",
                                 paths.private_key, paths.certificate));
  ERR_clear_error();
  const auto authorities = certificates(read(&SecurityParams::identity_ca));
  if (authorities.empty())
    faults.push_back(fmt::format("identity_ca: {} holds no certificate in PEM", paths.identity_ca));
  else if (const auto why = why_not_trusted(certificate, authorities); !why.empty())
    faults.push_back(
        fmt::format("certificate: {} is not accepted by identity_ca {}: {}; is the machine's clock right, "
                    "and are both of one keystore?",
                    paths.certificate, paths.identity_ca, why));
}

void check_permissions(const Contents& read, X509* certificate, Faults& faults) {
  const auto& paths = read.paths;
  const auto authorities = certificates(read(&SecurityParams::permissions_ca));
  if (authorities.empty()) {
    faults.push_back(fmt::format("permissions_ca: {} holds no certificate in PEM", paths.permissions_ca));
    return;
  }
  const auto not_signed = [&](const char* key, const std::string& path) {
    faults.push_back(
        fmt::format("{}: {} is not signed by permissions_ca {}; scripts/dds_keys.sh signs it after a "
                    "change",
                    key, path, paths.permissions_ca));
  };
  if (signed_text(read(&SecurityParams::governance), authorities).empty()) not_signed("governance", paths.governance);
  const std::string permissions = signed_text(read(&SecurityParams::permissions), authorities);
  if (permissions.empty()) return not_signed("permissions", paths.permissions);
  const auto named = subjects_in(permissions);
  const std::string subject = subject_of(certificate);
  if (std::none_of(named.begin(), named.end(),
                   [&](const std::string& name) { return without_spaces(name) == without_spaces(subject); }))
    faults.push_back(
        fmt::format("permissions: {} is about '{}', the certificate {} about '{}'; both must name the "
                    "subject in the same order",
                    paths.permissions, fmt::join(named, "', '"), paths.certificate, subject));
}

}  // namespace

bool is_secured(const SecurityParams& params) {
  return !params.folder.empty() || std::any_of(kSecurityFiles.begin(), kSecurityFiles.end(),
                                               [&](const auto& file) { return !(params.*file.path).empty(); });
}

SecurityParams with_folder(const SecurityParams& params) {
  SecurityParams out = params;
  for (const auto& file : kSecurityFiles)
    if ((out.*file.path).empty() && !out.folder.empty())
      out.*file.path = (std::filesystem::path(out.folder) / file.name).string();
  return out;
}

Faults check(const SecurityParams& params) {
  Faults faults;
  if (!is_secured(params)) return faults;
  std::error_code why;
  if (!params.folder.empty() && !std::filesystem::is_directory(params.folder, why))
    return {fmt::format("folder: {} is no folder that can be looked into{}{}; scripts/dds_keys.sh makes one",
                        params.folder, why ? ": " : "", why ? why.message() : "")};
  const SecurityParams paths = with_folder(params);
  Contents contents{paths, {}};
  read_all(contents, faults);
  if (!faults.empty()) return faults;
  const auto own = certificates(contents(&SecurityParams::certificate));
  if (own.empty()) return {fmt::format("certificate: {} holds no certificate in PEM", paths.certificate)};
  check_identity(contents, own.front().get(), faults);
  check_permissions(contents, own.front().get(), faults);
  return faults;
}

Faults warnings(const SecurityParams& params) {
  const std::string path = with_folder(params).private_key;
  struct stat about {};
  if (path.empty() || stat(path.c_str(), &about) != 0 || (about.st_mode & S_IROTH) == 0) return {};
  return {
      fmt::format("security: everybody on this machine may read the private key {}, and so be this participant; "
                  "`chmod o= {}`",
                  path, path)};
}

}  // namespace stillpoint::io
