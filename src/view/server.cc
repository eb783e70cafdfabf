// HTTP: addresses, answers, and what browsers are forbidden.
#include "view/server.h"

#include "core/error.h"
#include "core/log.h"
#include "core/option_range.h"
#include "core/stop_request.h"
#include "view/access.h"
#include "view/picture_request.h"
#include "view/session.h"
#include "view_page.h"

#include <httplib.h>

#include <chrono>
#include <memory>
#include <optional>
#include <thread>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* kLoopback = "127.0.0.1";
constexpr auto kRefreshEvery = 500ms, kStopEvery = 50ms;
constexpr size_t kMostRequestBytes = 4096;  // of a body, which no request needs
// A connection has a thread. Together these end a crowd of connections that ask for nothing.
constexpr int kThreads = 32, kSilence_s = 1;
constexpr int kDraftQuality = 80, kFullQuality = 95;

void Refuse(httplib::Response& response, int status, const std::string& reason) {
  response.status = status;
  response.set_content(OneLine(reason) + "\n", "text/plain; charset=utf-8");
}

// The page runs no script and loads nothing but its own, and the token reaches no other site.
httplib::Headers DefaultHeaders() {
  return {{"Cache-Control", "no-store"},
          {"Referrer-Policy", "no-referrer"},
          {"X-Content-Type-Options", "nosniff"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Content-Security-Policy",
           "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
           "connect-src 'self'; img-src blob: data:; base-uri 'none'; form-action 'none'; "
           "frame-ancestors 'none'"}};
}

// Why a request is not answered, and its status; nothing if it is.
struct Refusal {
  int status = 0;
  const char* reason = "";
};
std::optional<Refusal> RefusalOf(const httplib::Request& request, int port,
                                 const std::string& token) {
  const bool has_one_host = request.get_header_value_count("Host") == 1;
  if (!has_one_host || !IsLoopbackHost(request.get_header_value("Host"), port)) {
    return Refusal{403, "this host is not served"};
  }
  if (!HasToken(request.path, token)) {
    return Refusal{403, "the address lacks the token that tetrec-view printed"};
  }
  if (request.method != "GET" && request.method != "HEAD") {
    return Refusal{405, "only GET and HEAD are answered"};
  }
  // Thousands of ranges of one answer would be as many answers.
  if (request.has_header("Range")) return Refusal{400, "parts of answers are not served"};
  return std::nullopt;
}

void AnswerPicture(ViewSession& session, const httplib::Request& request,
                   httplib::Response& response) {
  try {
    const std::shared_ptr<const ShownScene> asked_of = session.scene();
    const PictureRequest wanted =
        ParsePictureRequest({request.params.begin(), request.params.end()}, asked_of->scene);
    const std::optional<Image> image = session.Draw(wanted, asked_of);
    if (!image) {
      response.status = 204;  // the page asks again; an error would appear in the console
      return;
    }
    const std::vector<uint8_t> jpeg =
        EncodeJpeg(*image, wanted.is_draft ? kDraftQuality : kFullQuality);
    response.set_content(std::string(jpeg.begin(), jpeg.end()), "image/jpeg");
  } catch (const UsageError& error) {
    Refuse(response, 400, error.what());
  } catch (const std::exception& error) {
    LogWarning("a picture failed: {}", error.what());
    Refuse(response, 500, error.what());
  }
}

void AddAnswers(httplib::Server& server, ViewSession& session, const std::string& token) {
  const std::string root = "/" + token + "/";
  server.Get(root, [](const httplib::Request&, httplib::Response& response) {
    response.set_content(kViewPage, "text/html; charset=utf-8");
  });
  server.Get(root + "scene", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(session.DescribeScene().dump(), "application/json");
  });
  server.Get(root + "status", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(session.Status().dump(), "application/json");
  });
  server.Get(root + "picture", [&](const httplib::Request& request, httplib::Response& response) {
    AnswerPicture(session, request, response);
  });
}

// The port.
int Bind(httplib::Server& server, int wanted) {
  // The library's own choice, SO_REUSEPORT, would share the port with another program.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  if (wanted == 0) {
    const int port = server.bind_to_any_port(kLoopback);
    if (port < 0) throw EnvironmentError("no port of 127.0.0.1 is free");
    return port;
  }
  if (!server.bind_to_port(kLoopback, wanted)) {
    throw EnvironmentError(
        fmt::format("port {} of 127.0.0.1 is taken or not allowed; choose another with --port, or "
                    "leave it out for any that is free",
                    wanted));
  }
  return wanted;
}

// The thread that listens, until the end of its life.
class Listening {
 public:
  explicit Listening(httplib::Server& server)
      : server_(server), thread_([&server] { server.listen_after_bind(); }) {}
  ~Listening() {
    while (!server_.is_running()) std::this_thread::sleep_for(1ms);  // stop() is lost before
    server_.stop();
    thread_.join();
  }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

 private:
  httplib::Server& server_;
  std::thread thread_;
};

}  // namespace

void ViewOptions::Check() const {
  CheckRange("port", port, 0, 65535);
  renderer.Check();
}

void RunViewer(const ViewOptions& options, const fs::path& run) {
  CatchStopSignals();
  ViewSession session(run, options.renderer);
  httplib::Server server;
  const int port = Bind(server, options.port);
  const std::string token = MakeToken();
  server.set_default_headers(DefaultHeaders());
  server.set_payload_max_length(kMostRequestBytes);
  server.set_tcp_nodelay(true);
  server.set_keep_alive_timeout(1);  // a stop waits for idle connections [s]
  server.set_read_timeout(kSilence_s);
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
    using Next = httplib::Server::HandlerResponse;
    const std::optional<Refusal> refusal = RefusalOf(request, port, token);
    if (!refusal) return Next::Unhandled;
    Refuse(response, refusal->status, refusal->reason);
    return Next::Handled;
  });
  AddAnswers(server, session, token);
  {
    const Listening listening(server);
    fmt::print("http://{}:{}/{}/\n", kLoopback, port, token);
    std::fflush(stdout);
    LogInfo("open this address in a browser on this machine; Ctrl-C ends the viewer");
    auto refreshed = std::chrono::steady_clock::now();
    while (!StopRequested()) {
      std::this_thread::sleep_for(kStopEvery);
      if (std::chrono::steady_clock::now() - refreshed < kRefreshEvery) continue;
      session.Refresh();
      refreshed = std::chrono::steady_clock::now();
    }
  }
  ThrowIfStopRequested("the viewer has written nothing");
}

}  // namespace tetrec
