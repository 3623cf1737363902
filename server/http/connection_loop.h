// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "server/http/file_descriptor.h"
#include "server/http/http_engine.h"
#include "server/http/http_server.h"

namespace waystone {

// All sockets of the server, in one thread: takes connections, reads whole requests within the
// bounds of HttpOptions, hands them to the threads of a RequestPool, and writes what these answer.
// No client holds a thread, however slowly it sends or reads. Where connections run out, the one
// that has been idle longest makes room, else the slowest one. Internal to server/http.
class ConnectionLoop {
 public:
  using Answer = std::function<SentResponse(ReceivedRequest)>;

  // `answer` is called from several threads at once. Throws MapError(kInternal) when there is no
  // descriptor left.
  ConnectionLoop(FileDescriptor listener, const HttpOptions& options, HttpServer::Admit admit,
                 Answer answer);
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
