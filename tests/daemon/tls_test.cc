// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast.hpp>
#include <boost/beast/ssl.hpp>

#include <cstdio>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "core/base/error.h"
#include "daemon/server.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

// A certificate for localhost that signs itself, and its key, as PEM files.
void WriteCertificate(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  EVP_PKEY* pair = EVP_EC_gen("P-256");
  X509* x509 = X509_new();
  ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
  X509_gmtime_adj(X509_getm_notBefore(x509), -3600);
  X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
  X509_set_pubkey(x509, pair);
  X509_NAME* name = X509_get_subject_name(x509);
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
  X509_set_issuer_name(x509, name);
  X509_sign(x509, pair, EVP_sha256());
  FILE* file = std::fopen(certificate.c_str(), "w");
  PEM_write_X509(file, x509);
  std::fclose(file);
  file = std::fopen(key.c_str(), "w");
  PEM_write_PrivateKey(file, pair, nullptr, nullptr, 0, nullptr, nullptr);
  std::fclose(file);
  std::filesystem::permissions(key, std::filesystem::perms(0600));
  X509_free(x509);
  EVP_PKEY_free(pair);
}

class TlsTest : public testing::Test {
 protected:
  TlsTest() {
    config_.folder = folder_.path();
    config_.store_folder = "store";
    config_.api_unix_socket = "";
    config_.api_port = config_.http_port = 0;
    config_.robot_port = -1;
    config_.http_page = "page";
    config_.http_certificate = "certificate.pem";
    config_.http_key = "key.pem";
    WriteCertificate(folder_.path() / "certificate.pem", folder_.path() / "key.pem");
    std::filesystem::create_directory(folder_.path() / "page");
    std::ofstream(folder_.path() / "page/index.html") << std::string(300000, 'x');
  }

  TemporaryFolder folder_;
  Config config_;
};

TEST_F(TlsTest, ServesPageMethodsAndWebSocketOverTls) {
  Server server(config_, SmallStation(SmallWorld(16)));
  std::thread thread([&] { server.Run(); });
  {
    asio::io_context io;
    asio::ssl::context context(asio::ssl::context::tls_client);
    context.load_verify_file((folder_.path() / "certificate.pem").string());
    context.set_verify_mode(asio::ssl::verify_peer);
    const asio::ip::tcp::endpoint endpoint(asio::ip::make_address("127.0.0.1"),
                                           static_cast<std::uint16_t>(server.http_port()));
    beast::flat_buffer buffer;
    {
      beast::ssl_stream<beast::tcp_stream> stream(io, context);
      beast::get_lowest_layer(stream).connect(endpoint);
      stream.handshake(asio::ssl::stream_base::client);
      http::request<http::string_body> request(http::verb::get, "/", 11);
      request.set(http::field::host, "localhost");
      http::write(stream, request);
      http::response<http::string_body> page;
      http::read(stream, buffer, page);
      EXPECT_EQ(page.body().size(), 300000u);
      request.method(http::verb::post);
      request.target("/rpc");
      request.set(http::field::content_type, "application/json");
      request.body() = R"({"jsonrpc":"2.0","id":1,"method":"station.status"})";
      request.prepare_payload();
      http::write(stream, request);
      http::response<http::string_body> answer;
      http::read(stream, buffer, answer);
      const nlohmann::json status = nlohmann::json::parse(answer.body())["result"];
      EXPECT_EQ(status["state"], "idle");
      EXPECT_EQ(status["http"], "https://127.0.0.1:" + std::to_string(server.http_port()));
    }
    beast::websocket::stream<beast::ssl_stream<beast::tcp_stream>> socket(io, context);
    beast::get_lowest_layer(socket).connect(endpoint);
    socket.next_layer().handshake(asio::ssl::stream_base::client);
    socket.handshake("localhost", "/ws");
    buffer.clear();
    socket.read(buffer);
    EXPECT_NE(beast::buffers_to_string(buffer.data()).find("greeting"), std::string::npos);
  }
  {
    // Without TLS nobody is understood, and nothing breaks.
    asio::io_context io;
    asio::ip::tcp::socket plain(io);
    plain.connect({asio::ip::make_address("127.0.0.1"), static_cast<std::uint16_t>(server.http_port())});
    asio::write(plain, asio::buffer(std::string("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")));
    std::string rest;
    boost::system::error_code error;
    asio::read(plain, asio::dynamic_buffer(rest), error);
    EXPECT_EQ(rest.find("HTTP/1.1 200"), std::string::npos);
  }
  server.Stop();
  thread.join();
}

TEST_F(TlsTest, MistakesAreFatalAndNamed) {
  const auto fails = [&](const char* key) {
    try {
      Server server(config_, SmallStation(SmallWorld(16)));
    } catch (const ConfigError& error) {
      return error.call() == key && !error.remedy().empty();
    }
    return false;
  };
  std::filesystem::permissions(folder_.path() / "key.pem", std::filesystem::perms(0644));
  EXPECT_TRUE(fails("http.key")) << "others can read it";
  std::filesystem::permissions(folder_.path() / "key.pem", std::filesystem::perms(0600));
  config_.http_key = "absent.pem";
  EXPECT_TRUE(fails("http.key"));
  std::filesystem::permissions(folder_.path() / "certificate.pem", std::filesystem::perms(0600));
  config_.http_key = "certificate.pem";
  EXPECT_TRUE(fails("http.key")) << "no key";
  config_.http_key = "key.pem";
  config_.http_certificate = "key.pem";
  EXPECT_TRUE(fails("http.certificate"));
  EXPECT_THROW(ParseConfig("[http]\ncertificate = \"a.pem\"\n", "x.toml"), ConfigError) << "one without the other";
}

}  // namespace
}  // namespace geond::daemon
