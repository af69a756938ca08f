// A camera's stream, as segment reads it: once, from its first picture on, until Ctrl-C.
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

constexpr int kFrames = 600;  // more than are read before the end is asked for
constexpr int kWanted = 5, kShort = 6;

// Sends bytes, a few pictures at a time, to each who connects to a port of its own on this machine.
class Sender {
 public:
  explicit Sender(std::string bytes) : bytes_(std::move(bytes)) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~Sender() {
    stops_ = true;
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }

  std::string address() const { return absl::StrCat("tcp://127.0.0.1:", port_); }
  int connections() const { return connections_; }

 private:
  void Serve() {
    while (!stops_) {
      const int peer = accept(listener_, nullptr, nullptr);
      if (peer < 0) return;
      ++connections_;
      constexpr size_t kPiece = 16 << 10;
      for (size_t at = 0; at < bytes_.size() && !stops_; at += kPiece) {
        const size_t size = std::min(kPiece, bytes_.size() - at);
        if (send(peer, bytes_.data() + at, size, MSG_NOSIGNAL) < 0) break;
        usleep(20000);
      }
      close(peer);
    }
  }

  std::string bytes_;
  int listener_ = -1, port_ = 0;
  std::atomic<int> connections_{0};
  std::atomic<bool> stops_{false};
  std::thread thread_;
};

class Stream : public testing::Test {
 protected:
  Stream() : root_(FreshFolder()), run_(root_ + "/run") {}

  // Of the first frames of one drive.
  std::string Video(int frames) const {
    const std::string path = root_ + "/drive.avi";
    WritePatchVideo(path, SmallPatchDrive(kFrames), frames);
    return *ReadFile(path);
  }

  std::vector<std::string> Segment(const std::string& address,
                                   const std::vector<std::string>& more = {}) const {
    return std::vector<std::string>{"segment",      address,      "--out=" + run_,
                                    "--budget=100", "--stride=8", "--progress=none"} +
           more;
  }

  std::string root_, run_;
};

TEST_F(Stream, IsSegmentedAsItComesUntilItsReaderEndsIt) {
  const Sender sender(Video(kFrames));
  const pid_t program =
      StartProgram(Segment(sender.address(), {"--record"}), root_ + "/out.txt", root_ + "/err.txt");
  const std::string wanted = run_ + absl::StrFormat("/grid/%06d.prob.png", kWanted - 1);
  WaitUntil([&] { return std::filesystem::exists(wanted); });
  kill(program, SIGINT);
  EXPECT_EQ(WaitForProgram(program), 0) << *ReadFile(root_ + "/err.txt");
  EXPECT_EQ(sender.connections(), 1);  // nothing was read twice
  const RunFolder folder = *RunFolder::Open(run_);
  EXPECT_EQ(folder.ReadDescription()->ended, "done");
  const std::vector<FrameLine> lines = *folder.ReadLines();
  ASSERT_GE(lines.size(), static_cast<size_t>(kWanted));
  EXPECT_LT(lines.size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(lines.front().index, 0);
  // Its first picture, but for what JPEG makes of it.
  const cv::Mat first = cv::imread(folder.FrameFile("frames", 0, ".png"));
  EXPECT_LT(cv::norm(first, PatchFrame(SmallPatchDrive(kFrames), 0), cv::NORM_L1) /
                static_cast<double>(first.total() * 3),
            10.0);
  // What was recorded is what follows reads.
  EXPECT_THAT(RunProgram({"refine", run_, "--progress=none"}), Succeeds());
  EXPECT_TRUE(std::filesystem::exists(folder.FrameFile("masks", kWanted - 1, ".png")));
}

TEST_F(Stream, ThatIsNotRecordedIsGone) {
  const Sender sender(Video(kShort));
  ASSERT_THAT(RunProgram(Segment(sender.address())), Succeeds());
  EXPECT_EQ(RunFolder::Open(run_)->ReadLines()->size(), static_cast<size_t>(kShort));
  EXPECT_THAT(RunProgram({"refine", run_, "--progress=none"}),
              EndsWithLine(3, "give its recording"));
  EXPECT_EQ(sender.connections(), 1);
  for (const char* flag : {"--resume", "--from=3", "--ahead=2"}) {
    EXPECT_THAT(RunProgram(Segment(sender.address(), {flag})),
                Says(2, "a stream is read once, as it comes"))
        << flag;
  }
  run_ = root_ + "/nothing";
  EXPECT_THAT(RunProgram(Segment("tcp://me:secret@127.0.0.1:1")),
              EndsWithLine(3, "tcp://127.0.0.1:1: no stream that FFmpeg can open"));
  EXPECT_FALSE(std::filesystem::exists(run_));
}

}  // namespace
}  // namespace egosieve::tools
