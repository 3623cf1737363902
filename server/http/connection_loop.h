// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/http_engine.h"
#include "server/http/http_server.h"

namespace waystone {

// All sockets of the server, in one thread: takes connections, reads whole requests within the
// bounds of HttpOptions, hands them to the threads of a RequestPool, and writes what these answer.
// No client holds a thread, however slowly it sends or reads. Where connections run out, the one
// that has been idle longest makes room, else the slowest one. Inside server/http only.
class ConnectionLoop {
 public:
  using Answer = std::function<SentResponse(ReceivedRequest)>;
  // Whether a body is worth reading, by the value of the header Authorization (empty without one).
  using Admit = std::function<bool(const std::string& authorization)>;

  // Takes over the listening socket. `answer` is called from several threads at once.
  ConnectionLoop(int listener, const HttpOptions& options, Admit admit, Answer answer);
  ~ConnectionLoop();  // as Stop
  ConnectionLoop(const ConnectionLoop&) = delete;
  ConnectionLoop& operator=(const ConnectionLoop&) = delete;

  void Start();
  // From now on each answer closes its connection. Thread-safe.
  void Drain();
  // Takes no more connections, closes those whose request hasn't arrived completely, and waits for
  // the answers to the others, but not longer than options.stop_timeout_s for clients to read them;
  // `on_late` is called when some are still being computed then. Returns when all threads ended.
  void Stop(const std::function<void()>& on_late = nullptr);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace waystone
