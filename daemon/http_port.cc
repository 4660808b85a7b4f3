// SPDX-License-Identifier: Apache-2.0
#include "daemon/http_port.h"

#include <sys/stat.h>

#include "core/base/error.h"
#include "daemon/http_session.h"

namespace geond::daemon {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

// TLS 1.2 and up, with a certificate and a key that nobody else can read.
asio::ssl::context TlsContext(const HttpOptions& options) {
  struct stat status {};
  if (stat(options.key.c_str(), &status) == 0 && (status.st_mode & (S_IRWXO | S_IWGRP)) != 0) {
    throw ConfigError("geond.toml", "http.key", options.key.string() + " can be read or changed by others",
                      "Run chmod 640 on it");
  }
  asio::ssl::context tls(asio::ssl::context::tls_server);
  tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                  asio::ssl::context::no_tlsv1_1);
  try {
    tls.use_certificate_chain_file(options.certificate.string());
  } catch (const boost::system::system_error& error) {
    throw ConfigError("geond.toml", "http.certificate", options.certificate.string() + ": " + error.code().message(),
                      "It must be a PEM file with the certificate and those above it");
  }
  try {
    tls.use_private_key_file(options.key.string(), asio::ssl::context::pem);
  } catch (const boost::system::system_error& error) {
    throw ConfigError("geond.toml", "http.key", options.key.string() + ": " + error.code().message(),
                      "It must be the PEM file of the certificate's own key, without a passphrase");
  }
  return tls;
}

}  // namespace

void CheckCertificate(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  HttpOptions options;
  options.certificate = certificate;
  options.key = key;
  TlsContext(options);
}

void HttpPortParts::Accept() {
  acceptor.async_accept([weak = weak_from_this()](const error_code& error, asio::ip::tcp::socket socket) {
    const auto self = weak.lock();
    if (!self || error == asio::error::operation_aborted) return;
    if (!error) {
      const bool full = self->clients >= self->options.max_clients;
      if (full) self->handlers.refused("too_many_clients");
      if (!self->tls) {
        auto session = std::make_shared<HttpSession<PlainStream>>(PlainStream(std::move(socket)), self);
        if (full) {
          session->TurnAway();
        } else {
          session->Start();
        }
      } else if (!full) {
        std::make_shared<HttpSession<TlsStream>>(TlsStream(std::move(socket), *self->tls), self)->Start();
      }
    }
    self->Accept();
  });
}

HttpPort::HttpPort(void* io_context, const HttpOptions& options, HttpHandlers handlers)
    : parts_(
          std::make_shared<HttpPortParts>(*static_cast<asio::io_context*>(io_context), options, std::move(handlers))) {
  if (!options.certificate.empty()) parts_->tls.emplace(TlsContext(options));
  try {
    const asio::ip::tcp::endpoint endpoint(asio::ip::make_address(options.address),
                                           static_cast<std::uint16_t>(options.port));
    if (!endpoint.address().is_loopback() && parts_->handlers.tokens->empty()) {
      throw ConfigError("geond.toml", "http.address",
                        options.address + " can be reached from outside, and there are no tokens",
                        "Use 127.0.0.1, or name a file of tokens (api.tokens)");
    }
    parts_->acceptor.open(endpoint.protocol());
    parts_->acceptor.set_option(asio::ip::tcp::acceptor::reuse_address(true));
    parts_->acceptor.set_option(asio::ip::tcp::no_delay(true));  // what it accepts inherits it
    parts_->acceptor.bind(endpoint);
    parts_->acceptor.listen();
  } catch (const boost::system::system_error& failure) {
    throw ConfigError("geond.toml", "http.port",
                      std::to_string(options.port) + " cannot be used: " + failure.code().message(),
                      "Another program listens there; choose another port, 0 for any or -1 for none");
  }
  parts_->Accept();
}

HttpPort::~HttpPort() {
  error_code ignored;
  parts_->acceptor.close(ignored);
  parts_->ended = true;  // connections live on in the io_context until that ends
}

int HttpPort::port() const { return parts_->acceptor.local_endpoint().port(); }

}  // namespace geond::daemon
