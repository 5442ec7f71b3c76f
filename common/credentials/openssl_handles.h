#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include "common/handle/handle.h"

namespace haptics::openssl {

using Key = Handle<EVP_PKEY, &EVP_PKEY_free>;
using Certificate = Handle<X509, &X509_free>;
using Bio = Handle<BIO, &BIO_free>;

}  // namespace haptics::openssl
