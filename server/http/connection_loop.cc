// SPDX-License-Identifier: Apache-2.0
#include "server/http/connection_loop.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <list>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/start_thread.h"
#include "server/http/connection.h"
#include "server/http/file_limit.h"
#include "server/http/poller.h"
#include "server/http/request_pool.h"

namespace waystone {
namespace {

constexpr uint64_t kListener = 1;  // its id in the poller; connections have the next ones
constexpr int kTickMs = 100;       // between looks at the deadlines
constexpr size_t kReadBytes = 65'536;
constexpr int kReadsAtOnce = 8;  // of one connection before others get their turn

std::string AddressText(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> text{};
  const int failed = getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, text.data(),
                                 text.size(), nullptr, 0, NI_NUMERICHOST);
  return failed != 0 ? "" : text.data();
}

}  // namespace

class ConnectionLoop::Impl {
 public:
  Impl(FileDescriptor listener, const HttpOptions& options, HttpServer::Admit admit, Answer answer)
      : options_(options),
        admit_(std::move(admit)),
        answer_(std::move(answer)),
        budgets_{ByteBudget(options.max_bodies_bytes), ByteBudget(options.max_bodies_bytes)},
        listener_(std::move(listener)),
        max_connections_(RaiseFileLimit(options.max_connections)) {
    if (!admit_) admit_ = [](const std::string&) { return true; };
    Listen(true);
  }
  ~Impl() { Stop(nullptr); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void Start() {
    pool_ = std::make_unique<RequestPool>(options_.request_threads);
    thread_ = StartThread([this] { Run(); });
  }

  void Drain() { draining_ = true; }

  void Stop(const std::function<void()>& on_late) {
    if (!thread_.joinable()) return;
    draining_ = true;
    stopping_ = true;
    poller_.WakeUp();
    thread_.join();
    if (on_late && late_) on_late();
    pool_->Stop();
  }

 private:
  struct Client {
    Client(FileDescriptor taken, std::string remote, const HttpOptions& options,
           const HttpServer::Admit& admit, ByteBudgets& budgets)
        : socket(std::move(taken)), connection(std::move(remote), options, admit, budgets) {}

    FileDescriptor socket;
    Connection connection;
    uint32_t watched = 0;      // the poller's events; 0: none
    bool half_closed = false;  // we send no more
  };

  using Clients = std::map<uint64_t, Client>;
  struct Finished {
    uint64_t id = 0;
    SentResponse response;
  };
  // One request on its way through the threads. Its place in the list of answers is made with it,
  // so that an answer is never lost for want of memory.
  struct Exchange {
    ReceivedRequest request;
    std::list<Finished> finished;
  };

  // Whether new connections are taken.
  void Listen(bool wanted) {
    const bool changed =
        poller_.Watch(listener_.get(), kListener, listens_ ? EPOLLIN : 0U, wanted ? EPOLLIN : 0U);
    if (changed) listens_ = wanted;
  }

  void Run() {
    while (!stopping_ || !Ended()) {
      for (const epoll_event& event : poller_.Wait(kTickMs)) OnEvent(event);
      TakeFinished();
      if (stopping_) BeginEnd();
      if (SecondsSince(last_tick_) * 1e3 >= kTickMs) OnTick();
    }
    clients_.clear();
  }

  void OnEvent(const epoll_event& event) {
    const uint64_t id = event.data.u64;
    if (id == kListener) {
      try {
        return Accept();
      } catch (const std::bad_alloc&) {
        return;  // the connection was closed
      }
    }
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;  // closed by an event before
    Step(found, [&] {
      if ((event.events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0) Receive(found->second);
    });
  }

  void Accept() {
    while (true) {
      const bool full = std::ssize(clients_) >= max_connections_;
      if (full && FirstToEvict() == clients_.end()) return Listen(false);
      sockaddr_storage address{};
      socklen_t size = sizeof(address);
      FileDescriptor socket(accept4(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size,
                                    SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (socket.get() < 0) {
        const bool out_of_files = errno == EMFILE || errno == ENFILE;
        if (out_of_files && !Evict()) Listen(false);
        return;
      }
      if (full) Evict();  // not before there is one to make room for
      const int on = 1;
      setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
      const auto [client, added] = clients_.try_emplace(
          next_id_++, std::move(socket), AddressText(address, size), options_, admit_, budgets_);
      // One whose request is there already isn't idle, and makes no room for the next.
      Step(client, [&, it = client] { Receive(it->second); });
    }
  }

  // The connection whose end does least harm: one that only waits for its client to close, else the
  // one that has been idle longest, else the one that has been sending or taking bytes longest.
  Clients::iterator FirstToEvict() {
    return First([](const Connection& connection) -> std::optional<int> {
      if (connection.state() == ConnectionState::kAnswer) return std::nullopt;
      if (connection.state() == ConnectionState::kClosing) return 0;
      return connection.is_idle() ? 1 : 2;
    });
  }

  bool Evict() { return Close(FirstToEvict()); }

  // Closes the connection that has been taking its answer longest.
  bool EvictReader() {
    return Close(First([](const Connection& connection) -> std::optional<int> {
      if (connection.state() != ConnectionState::kWriting) return std::nullopt;
      return 0;
    }));
  }

  // Whether there was one.
  bool Close(Clients::iterator client) {
    if (client == clients_.end()) return false;
    clients_.erase(client);
    return true;
  }

  // The longest waiting one of the connections of the lowest rank, but none without a rank.
  template <class Rank>
  Clients::iterator First(const Rank& rank) {
    auto first = clients_.end();
    std::pair<int, Clock::time_point> lowest;
    for (auto it = clients_.begin(); it != clients_.end(); ++it) {
      const std::optional<int> own = rank(it->second.connection);
      if (!own) continue;
      const std::pair key(*own, it->second.connection.since());
      if (first != clients_.end() && key >= lowest) continue;
      first = it;
      lowest = key;
    }
    return first;
  }

  void Receive(Client& client) {
    for (int i = 0; i < kReadsAtOnce && client.connection.wants_input(); ++i) {
      const ssize_t size = recv(client.socket.get(), buffer_.data(), buffer_.size(), 0);
      if (size > 0) {
        client.connection.Receive({buffer_.data(), static_cast<size_t>(size)});
        continue;
      }
      if (size == 0 || (errno != EAGAIN && errno != EINTR)) client.connection.ReceiveEnd();
      return;
    }
  }

  // Does `first`, hands over a request, writes what there is, and waits for what comes next. A
  // connection that there is no memory for is closed.
  template <class First>
  void Step(Clients::iterator it, const First& first) {
    try {
      first();
      Continue(it);
    } catch (const std::bad_alloc&) {
      clients_.erase(it);
    }
  }

  void Continue(Clients::iterator it) {
    Client& client = it->second;
    while (true) {
      if (client.connection.has_request()) Ask(it->first, client.connection);
      if (!Write(client)) break;
    }
    if (client.connection.finished()) {
      clients_.erase(it);
      return Listen(!stopping_);
    }
    if (client.connection.state() == ConnectionState::kClosing && !client.half_closed) {
      shutdown(client.socket.get(), SHUT_WR);
      client.half_closed = true;
    }
    const uint32_t wanted = (client.connection.wants_input() ? EPOLLIN : 0U) |
                            (client.connection.out().empty() ? 0U : EPOLLOUT);
    if (!poller_.Watch(client.socket.get(), it->first, client.watched, wanted)) {
      clients_.erase(it);  // no event would ever come
      return;
    }
    client.watched = wanted;
  }

  // Whether a pipelined request came up behind what was written.
  bool Write(Client& client) {
    while (!client.connection.out().empty()) {
      const std::string_view out = client.connection.out();
      const ssize_t size = send(client.socket.get(), out.data(), out.size(), MSG_NOSIGNAL);
      if (size < 0) {
        if (errno != EAGAIN && errno != EINTR) client.connection.Fail();
        return false;
      }
      client.connection.Sent(static_cast<size_t>(size));
    }
    return client.connection.has_request();
  }

  void Ask(uint64_t id, Connection& connection) {
    auto exchange = std::make_shared<Exchange>();
    exchange->finished.push_back({.id = id, .response = {}});
    exchange->request = connection.TakeRequest();
    pool_->Add([this, exchange] { Compute(*exchange); }, connection.is_urgent());
    ++asked_;
  }

  // In a thread of the pool.
  void Compute(Exchange& exchange) {
    SentResponse& response = exchange.finished.front().response;
    exchange.request.close |= draining_;
    try {
      response = answer_(std::move(exchange.request));
    } catch (const std::exception&) {
      response.close = true;  // there was no memory for an answer
    }
    {
      const std::lock_guard guard(mutex_);
      finished_.splice(finished_.end(), exchange.finished);
    }
    poller_.WakeUp();
  }

  void TakeFinished() {
    std::list<Finished> finished;
    {
      const std::lock_guard guard(mutex_);
      finished.swap(finished_);
    }
    for (Finished& each : finished) {
      --asked_;
      const auto found = clients_.find(each.id);
      if (found == clients_.end()) continue;
      Step(found, [&] { found->second.connection.TakeAnswer(each.response); });
      while (budgets_.answers.spent() && EvictReader()) {
      }
    }
  }

  void OnTick() {
    last_tick_ = Clock::now();
    for (auto it = clients_.begin(); it != clients_.end();) {
      const auto client = it++;
      if (client->second.connection.deadline() > last_tick_) continue;
      Step(client, [&] { client->second.connection.OnTimeout(); });
    }
    Listen(!stopping_);
  }

  // Once, when the server stops: no client that hasn't sent its request is waited for.
  void BeginEnd() {
    if (end_) return;
    end_ = Clock::now() + std::chrono::seconds(options_.stop_timeout_s);
    Listen(false);
    listener_.Close();
    std::erase_if(clients_, [](const auto& client) {
      const ConnectionState state = client.second.connection.state();
      return state == ConnectionState::kHead || state == ConnectionState::kBody;
    });
  }

  bool Ended() {
    if (!end_) return false;
    const bool writing = std::ranges::any_of(clients_, [](const auto& client) {
      return client.second.connection.state() == ConnectionState::kWriting;
    });
    if (!writing && asked_ == 0) return true;
    late_ = Clock::now() >= *end_ && asked_ > 0;
    return Clock::now() >= *end_;
  }

  const HttpOptions options_;
  HttpServer::Admit admit_;
  Answer answer_;
  ByteBudgets budgets_;
  FileDescriptor listener_;
  Poller poller_;
  const int max_connections_;
  bool listens_ = false;
  std::array<char, kReadBytes> buffer_{};
  uint64_t next_id_ = kListener + 1;
  Clients clients_;
  int asked_ = 0;  // requests whose answers haven't been taken
  Clock::time_point last_tick_ = Clock::now();
  std::optional<Clock::time_point> end_;
  bool late_ = false;
  std::atomic<bool> draining_ = false;
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::list<Finished> finished_;  // by the mutex
  std::unique_ptr<RequestPool> pool_;
  std::thread thread_;
};

ConnectionLoop::ConnectionLoop(FileDescriptor listener, const HttpOptions& options,
                               HttpServer::Admit admit, Answer answer)
    : impl_(std::make_unique<Impl>(std::move(listener), options, std::move(admit),
                                   std::move(answer))) {}
ConnectionLoop::~ConnectionLoop() = default;

void ConnectionLoop::Start() { impl_->Start(); }
void ConnectionLoop::Drain() { impl_->Drain(); }
void ConnectionLoop::Stop(const std::function<void()>& on_late) { impl_->Stop(on_late); }

}  // namespace waystone
