// SPDX-License-Identifier: Apache-2.0
#include "daemon/server.h"

#include <csignal>

#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include "core/base/error.h"
#include "daemon/http_port.h"
#include "daemon/line_session.h"
#include "daemon/robot/allow_list.h"
#include "daemon/robot/robot_protocol.h"
#include "daemon/service.h"
#include "sim/sim_config.h"

namespace geond::daemon {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

// A socket's file left by a dead process is removed; one that somebody answers on is not ours to take.
void RemoveStaleSocket(asio::io_context& io, const std::string& path) {
  asio::local::stream_protocol::socket probe(io);
  error_code error;
  probe.connect(asio::local::stream_protocol::endpoint(path), error);
  if (!error) {
    throw ConfigError("geond", "api.unix_socket", path + " is in use", "Another geond runs; stop it or choose another path");
  }
  if (std::filesystem::is_socket(path)) std::filesystem::remove(path);
}

constexpr auto kHousekeeping = std::chrono::minutes(5);

Json ErrorLine(const RpcError& error) { return {{"jsonrpc", "2.0"}, {"id", nullptr}, {"error", error.ToJson()}}; }

}  // namespace

struct Server::Parts {
  explicit Parts(const Config& config)
      : limits{static_cast<std::size_t>(config.api_max_line_kb) * 1024, static_cast<std::size_t>(config.api_max_unread_kb) * 1024},
        max_clients(static_cast<std::size_t>(config.api_max_clients)) {}

  void ListenTcp(const Config& config);
  void ListenUnix(const Config& config);
  template <typename Acceptor>
  void Accept(Acceptor& acceptor);
  void Serve(LineSession::Socket socket, bool by_unix_socket);
  void ListenRobot(const Config& config);
  void AcceptRobot();
  void ListenHttp(const Config& config);
  void ServeRobot(asio::ip::tcp::socket socket);
  void WatchLines();
  void WatchSignals(const std::function<Config()>& reload);
  void TellManager(std::chrono::microseconds period);

  LineLimits limits;
  std::size_t max_clients;
  asio::io_context io{1};
  std::unique_ptr<Service> service;
  std::unique_ptr<HttpPort> http;
  asio::ip::tcp::acceptor tcp{io};
  asio::ip::tcp::acceptor robot{io};
  AllowList robots;
  std::size_t robot_clients = 0;
  asio::local::stream_protocol::acceptor local{io};
  std::string local_path;
  asio::posix::stream_descriptor lines{io};
  asio::steady_timer lines_timer{io}, manager_timer{io};
  asio::signal_set signals{io};
  std::chrono::steady_clock::time_point next_housekeeping{};
  std::uint64_t connections = 0;
};

namespace {

void Listen(asio::ip::tcp::acceptor& acceptor, const asio::ip::address& address, int port, const std::string& key) {
  try {
    const asio::ip::tcp::endpoint endpoint(address, static_cast<std::uint16_t>(port));
    acceptor.open(endpoint.protocol());
    acceptor.set_option(asio::ip::tcp::acceptor::reuse_address(true));
    acceptor.set_option(asio::ip::tcp::no_delay(true));  // what it accepts inherits it
    acceptor.bind(endpoint);
    acceptor.listen();
  } catch (const boost::system::system_error& failure) {
    throw ConfigError("geond.toml", key, std::to_string(port) + " cannot be used: " + failure.code().message(),
                      "Another program listens there; choose another port, or 0 for any");
  }
}

// The networks that robots may come from; a mistake in them is fatal.
AllowList Networks(const Config& config) {
  try {
    return AllowList(config.robot_allow);
  } catch (const std::invalid_argument& wrong) {
    throw ConfigError("geond.toml", "robot.allow", wrong.what(), "Write networks as \"192.168.1.0/24, 10.0.0.7\"");
  }
}

asio::ip::address Address(const std::string& text, const std::string& key) {
  error_code error;
  const asio::ip::address address = asio::ip::make_address(text, error);
  if (error) throw ConfigError("geond.toml", key, "'" + text + "' is no IP address", "Try 127.0.0.1");
  return address;
}

}  // namespace

void Server::Parts::ListenTcp(const Config& config) {
  const asio::ip::address address = Address(config.api_address, "api.address");
  if (!address.is_loopback() && config.api_tokens.empty()) {
    throw ConfigError("geond.toml", "api.address", config.api_address + " can be reached from outside, and there are no tokens",
                      "Use 127.0.0.1 (and an SSH tunnel to reach it), or name a file of tokens (api.tokens)");
  }
  Listen(tcp, address, config.api_port, "api.port");
}

void Server::Parts::ListenRobot(const Config& config) {
  if (config.robot_port < 0) return;
  robots = Networks(config);
  const asio::ip::address address = Address(config.robot_address, "robot.address");
  if (!address.is_loopback() && robots.empty()) {
    throw ConfigError("geond.toml", "robot.allow", "it is empty, but " + config.robot_address + " can be reached from outside",
                      "Name the networks whose robots may connect");
  }
  Listen(robot, address, config.robot_port, "robot.port");
}

void Server::Parts::ListenUnix(const Config& config) {
  if (config.api_unix_socket.empty()) return;
  // The service manager may have made it already; then it is its own to remove.
  for (int fd = SD_LISTEN_FDS_START, end = fd + std::max(0, sd_listen_fds(0)); fd < end; ++fd) {
    if (sd_is_socket_unix(fd, SOCK_STREAM, 1, config.api_unix_socket.c_str(), 0) > 0) {
      local.assign(asio::local::stream_protocol(), dup(fd));
      return;
    }
  }
  local_path = config.api_unix_socket;
  try {
    RemoveStaleSocket(io, local_path);
    const asio::local::stream_protocol::endpoint endpoint(local_path);
    local.open(endpoint.protocol());
    local.bind(endpoint);
    std::filesystem::permissions(local_path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write |
                                                 std::filesystem::perms::group_read | std::filesystem::perms::group_write);
    local.listen();
  } catch (const boost::system::system_error& failure) {
    local_path.clear();
    throw ConfigError("geond.toml", "api.unix_socket", config.api_unix_socket + " cannot be made: " + failure.code().message(),
                      "Make its folder, or set another path (--set api.unix_socket=PATH)");
  }
}

template <typename Acceptor>
void Server::Parts::Accept(Acceptor& acceptor) {
  acceptor.async_accept([this, &acceptor](const error_code& error, typename Acceptor::protocol_type::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      Serve(LineSession::Socket(std::move(socket)),
            std::is_same_v<typename Acceptor::protocol_type, asio::local::stream_protocol>);
    } else {
      spdlog::warn("a connection could not be taken: {}", error.message());
    }
    Accept(acceptor);
  });
}

void Server::Parts::Serve(LineSession::Socket socket, bool by_unix_socket) {
  auto session = std::make_shared<LineSession>(std::move(socket), limits);
  auto client = std::make_shared<Client>();
  client->id = ++connections;
  client->role = service->FirstRole(by_unix_socket);
  if (service->clients() >= max_clients) {
    session->Start({[](std::string_view) {}, {}, {}, [] { return std::string(); }});
    session->Send(ErrorLine(RpcError(RpcError::Code::kTooManyClients,
                                     "there are " + std::to_string(max_clients) + " clients already",
                                     "Close one, or raise api.max_clients")).dump());
    session->CloseWhenSent();
    service->CountRefusal("too_many_clients");
    return;
  }
  client->send = [weak = std::weak_ptr(session)](std::string line) {
    if (const auto alive = weak.lock()) alive->Send(std::move(line));
  };
  service->AddClient(client.get());
  LineSession::Events events;
  events.on_line = [this, client](std::string_view line) {
    service->Answer(line, *client, client->send);
  };
  events.on_end = [this, client] { service->RemoveClient(client.get()); };
  events.too_long = [most = limits.max_line] {
    return ErrorLine(RpcError(RpcError::Code::kTooLarge, "the line is longer than " + std::to_string(most) + " bytes",
                              "Send one request a line")).dump();
  };
  events.on_slow = [this] { service->CountRefusal("slow_reader"); };
  session->Send(service->Greeting());
  session->Start(std::move(events));
}

void Server::Parts::ListenHttp(const Config& config) {
  if (config.http_port < 0) return;
  HttpOptions options;
  options.address = config.http_address;
  options.port = config.http_port;
  options.page = config.folder / config.http_page;
  if (!config.http_certificate.empty()) {
    options.certificate = config.folder / config.http_certificate;
    options.key = config.folder / config.http_key;
  }
  options.max_clients = max_clients;
  options.max_body = limits.max_line;
  options.max_unread = limits.max_unread;
  HttpHandlers handlers;
  handlers.answer = [this](std::string_view line, Client& client, const auto& respond) { service->Answer(line, client, respond); };
  handlers.greeting = [this] { return service->Greeting(); };
  handlers.add_client = [this](Client* client) { service->AddClient(client); };
  handlers.remove_client = [this](Client* client) { service->RemoveClient(client); };
  handlers.scan_file = [this](int scan, const std::string& name) { return service->ScanFile(scan, name); };
  handlers.export_scan = [this](int scan, const Service::PathReply& reply) { service->ExportScan(scan, reply); };
  handlers.import_file = [this] { return service->ImportFile(); };
  handlers.import_scan = [this](const std::filesystem::path& archive, const Reply& reply) { service->ImportScan(archive, reply); };
  handlers.refused = [this](const std::string& why) { service->CountRefusal(why); };
  handlers.tokens = &service->tokens();
  handlers.metrics = [this] { return service->Metrics(); };
  http = std::make_unique<HttpPort>(&io, options, std::move(handlers));
  const std::string host = options.address.find(':') == std::string::npos ? options.address : "[" + options.address + "]";
  service->SetHttpUrl((options.certificate.empty() ? "http://" : "https://") + host + ":" + std::to_string(http->port()));
}

void Server::Parts::AcceptRobot() {
  robot.async_accept([this](const error_code& error, asio::ip::tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) ServeRobot(std::move(socket));
    AcceptRobot();
  });
}

// One line in, one line out; DIALECT NAME changes how this connection is answered.
void Server::Parts::ServeRobot(asio::ip::tcp::socket socket) {
  error_code unknown;
  const asio::ip::address from = socket.remote_endpoint(unknown).address();
  if (unknown || robot_clients >= max_clients || !(from.is_loopback() || robots.Contains(from.to_string()))) {
    spdlog::warn("a robot at {} is turned away", unknown ? "?" : from.to_string());
    return;
  }
  ++robot_clients;
  auto session = std::make_shared<LineSession>(LineSession::Socket(std::move(socket)), LineLimits{kMaxRobotLine, 1 << 16, true});
  auto dialect = std::make_shared<RobotDialect>(*RobotDialectFromName(service->config().robot_dialect));
  RobotRecord bad;
  bad.status = RobotStatus::kBadRequest;
  LineSession::Events events;
  events.on_line = [this, weak = std::weak_ptr(session), dialect, bad, rate = std::make_shared<RateLimit>()](std::string_view line) {
    const auto alive = weak.lock();
    if (!alive) return;
    if (!rate->Allows(service->config().api_max_requests_per_s, std::chrono::steady_clock::now())) {
      service->CountRefusal("rate_limited");
      alive->Send(RobotAnswer(*dialect, bad, false));
      return;
    }
    if (line.substr(0, 8) == "DIALECT ") {
      const std::optional<RobotDialect> wanted = RobotDialectFromName(line.substr(8));
      if (wanted) *dialect = *wanted;
      alive->Send(RobotAnswer(*dialect, wanted ? RobotRecord() : bad, false));
      return;
    }
    const std::optional<RobotRequest> request = ParseRobotRequest(line);
    alive->Send(RobotAnswer(*dialect, request ? service->AnswerRobot(*request) : bad, request && HasPose(request->verb)));
  };
  events.on_end = [this] { --robot_clients; };
  events.too_long = [dialect, bad] { return RobotAnswer(*dialect, bad, false); };
  session->Start(std::move(events));
}

void Server::Parts::WatchLines() {
  if (lines.is_open()) {
    lines.async_wait(asio::posix::stream_descriptor::wait_read, [this](const error_code& error) {
      if (error) return;
      service->OnLinesEvent();
      WatchLines();
    });
  }
}

void Server::Parts::WatchSignals(const std::function<Config()>& reload) {
  signals.async_wait([this, reload](const error_code& error, int signal) {
    if (error) return;
    if (signal != SIGHUP) {
      spdlog::info("asked to end");
      service->StopAll("the service ends");
      io.stop();
      return;
    }
    sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld", static_cast<long long>(
        std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now().time_since_epoch()).count()));
    try {
      if (reload) service->Reload(reload());
    } catch (const Error& wrong) {
      spdlog::error("the configuration stays as it was: {}", wrong.what());
    }
    sd_notify(0, "READY=1");
    WatchSignals(reload);
  });
}

// Tells the service manager how things are, and that the threads live.
void Server::Parts::TellManager(std::chrono::microseconds period) {
  sd_notifyf(0, "STATUS=%s", service->StatusText().c_str());
  if (service->ThreadsAlive()) {
    sd_notify(0, "WATCHDOG=1");
  } else {
    spdlog::error("a thread makes no progress: the watchdog is not fed");
  }
  if (std::chrono::steady_clock::now() >= next_housekeeping) {
    next_housekeeping = std::chrono::steady_clock::now() + kHousekeeping;
    service->KeepHouse(std::chrono::system_clock::now(), std::chrono::steady_clock::now());
  }
  manager_timer.expires_after(period);
  manager_timer.async_wait([this, period](const error_code& error) {
    if (!error) TellManager(period);
  });
}

void CheckNamedFiles(const Config& config) {
  if (!config.api_tokens.empty()) AccessTokens(config.folder / config.api_tokens);
  Networks(config);
  if (!config.http_certificate.empty()) CheckCertificate(config.folder / config.http_certificate, config.folder / config.http_key);
  if (config.station_kind == "simulated") sim::ReadSimConfig(config.folder / config.station_simulation);
}

Server::Server(const Config& config, OpenedStation station) : parts_(std::make_unique<Parts>(config)) {
  parts_->ListenTcp(config);
  parts_->ListenUnix(config);
  parts_->ListenRobot(config);
  parts_->service = std::make_unique<Service>(config, std::move(station), [io = &parts_->io](std::function<void()> task) {
    asio::post(*io, std::move(task));
  });
  if (const int fd = parts_->service->lines_event_fd(); fd >= 0) parts_->lines.assign(dup(fd));
  parts_->ListenHttp(config);
  parts_->Accept(parts_->tcp);
  if (parts_->local.is_open()) parts_->Accept(parts_->local);
  if (parts_->robot.is_open()) parts_->AcceptRobot();
  parts_->WatchLines();
}

Server::~Server() {
  if (!parts_->local_path.empty()) ::unlink(parts_->local_path.c_str());
  parts_->http.reset();
  parts_->service.reset();
}

void Server::Run(bool signals, const std::function<Config()>& reload) {
  if (signals) {
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) parts_->signals.add(signal);
    parts_->WatchSignals(reload);
  }
  std::uint64_t watchdog_us = 0;
  sd_watchdog_enabled(0, &watchdog_us);
  sd_notify(0, "READY=1");
  parts_->TellManager(watchdog_us > 0 ? std::chrono::microseconds(watchdog_us / 2) : std::chrono::seconds(5));
  parts_->io.run();
  sd_notify(0, "STOPPING=1");
}

void Server::Stop() {
  asio::post(parts_->io, [this] {
    parts_->service->StopAll("the service ends");
    parts_->io.stop();
  });
}

int Server::port() const { return parts_->tcp.local_endpoint().port(); }

int Server::http_port() const { return parts_->http ? parts_->http->port() : -1; }

int Server::robot_port() const { return parts_->robot.is_open() ? parts_->robot.local_endpoint().port() : -1; }

void Server::Post(std::function<void(Service&)> task) {
  asio::post(parts_->io, [this, task = std::move(task)] { task(*parts_->service); });
}

}  // namespace geond::daemon
