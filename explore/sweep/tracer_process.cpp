// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/tracer_process.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "grtx/base/atomic_file.h"
#include "grtx/base/json.h"

namespace grtx::explore {

/// Standard input of the process. A socket: writing to an ended process then returns an error, while a pipe raises
/// SIGPIPE.
class TracerProcess::Requests {
 public:
  Requests() { open_ = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends_) == 0; }
  ~Requests() {
    close_child_end();
    if (open_) ::close(ends_[0]);
  }
  Requests(const Requests&) = delete;
  Requests& operator=(const Requests&) = delete;

  bool open() const { return open_; }
  int child_end() const { return ends_[1]; }
  /// Call after the process has inherited the far end; only then does send() notice the end of the process.
  void close_child_end() {
    if (open_ && ends_[1] >= 0) ::close(std::exchange(ends_[1], -1));
  }
  bool send(const std::string& text) const {
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t n = ::send(ends_[0], text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (n < 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }

 private:
  int ends_[2] = {-1, -1};
  bool open_ = false;
};

TracerProcess::TracerProcess(std::string program, const std::string& folder, const ProgramLimits& limits)
    : program_(std::move(program)), output_(folder + "/tracer.out"), errors_(folder + "/tracer.err"), limits_(limits) {}

TracerProcess::~TracerProcess() = default;

bool TracerProcess::start() {
  requests_sent_ = 0;
  std::filesystem::remove(output_);  // answers of an earlier process
  requests_ = std::make_unique<Requests>();
  if (!requests_->open()) return false;
  ProgramLimits limits;
  limits.memory_bytes = limits_.memory_bytes;
  process_ = std::make_unique<ProgramRun>(std::vector<std::string>{program_, "sweep", "--tracer"}, output_, errors_,
                                          limits, requests_->child_end());
  requests_->close_child_end();
  return true;
}

/// Answer number `count`, from 0; "" if it has not arrived yet.
std::string TracerProcess::answer(std::size_t count) const {
  if (!std::filesystem::exists(output_)) return "";
  const std::string text = read_file(output_);
  std::size_t begin = 0, end = text.find('\n');
  for (std::size_t i = 0; i < count && end != std::string::npos; ++i) {
    begin = end + 1;
    end = text.find('\n', begin);
  }
  return end == std::string::npos ? "" : text.substr(begin, end - begin);
}

TracerProcess::Result TracerProcess::trace(const std::vector<std::string>& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  Result result;
  const auto parse_answer = [&](const std::string& line) {
    if (line.empty()) return false;
    const auto json = nlohmann::json::parse(line, nullptr, false);
    result.done = json.is_object() && json.contains("structures_built");
    if (result.done) result.structures_built = json.at("structures_built").get<std::uint64_t>();
    return true;
  };
  const auto elapsed_seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  bool ended = false;
  const bool sent =
      (process_ != nullptr || start()) && requests_->send(exact_json_text(nlohmann::json(arguments)) + "\n");
  if (sent) {
    for (auto pause = std::chrono::milliseconds(1);; pause = std::min(2 * pause, std::chrono::milliseconds(20))) {
      ended = process_->poll().has_value();  // polled before reading, so that a last answer is not missed
      if (parse_answer(answer(requests_sent_)) || ended) break;
      if (limits_.seconds > 0.0 && elapsed_seconds() > limits_.seconds) {
        result.timeout = true;
        break;
      }
      std::this_thread::sleep_for(pause);
    }
  }
  result.seconds = elapsed_seconds();
  ++requests_sent_;
  if (!result.done || ended) {
    process_.reset();
    requests_.reset();
  }
  return result;
}

}  // namespace grtx::explore
