#include "vision/frame/file_list.h"

#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "tests/vision/frame/input_test.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class FileListTest : public InputTest {};

TEST_F(FileListTest, ListsGiveOrderAndTimes) {
  WritePicture("rgb/b.png", 10);
  WritePicture("rgb/a.png", 20);
  WriteText("rgb.txt",
            "# color images\n# timestamp filename\n1305031102.175304 rgb/b.png\n\n"
            "1305031102.211214 rgb/a.png\n");
  const Seen tum = ReadAllOf(Path("rgb.txt"));
  EXPECT_THAT(tum.values, ElementsAre(10, 20));
  EXPECT_THAT(tum.times, ElementsAre(1305031102.175304, 1305031102.211214));

  WritePicture("cam0/data/140.png", 30);
  WritePicture("cam0/data/141.png", 40);
  WriteText("cam0/data.csv",
            "#timestamp [ns],filename\r\n1403636579763555584,140.png\r\n"
            "1403636579813555456,141.png\r\n");
  const Seen euroc = ReadAllOf(Path("cam0/data.csv"));
  EXPECT_THAT(euroc.names, ElementsAre("140.png", "141.png"));
  EXPECT_NEAR(euroc.times[1] - euroc.times[0], 0.049999872, 1e-6);

  WriteText("names.csv", "file,time\nrgb/a.png,0.5\nrgb/b.png,0.7\n");
  EXPECT_THAT(ReadAllOf(Path("names.csv")).times, ElementsAre(0.5, 0.7));
  WriteText("bare.txt", "rgb/a.png\nrgb/b.png\n");
  EXPECT_THAT(ReadAllOf(Path("bare.txt")).times, ElementsAre(0.0, 0.1));
}

TEST_F(FileListTest, TimesOfAFolderComeFromAFile) {
  WritePicture("image_2/0.png", 10);
  WritePicture("image_2/1.png", 20);
  WriteText("times.txt", "0.000000e+00\n1.036220e-01\n");
  FrameSourceOptions options;
  options.times = Path("times.txt");
  EXPECT_THAT(ReadAllOf(Path("image_2"), options).times, ElementsAre(0.0, 0.103622));
  WriteText("times.txt", "2011-09-26 13:02:25.25\n2011-09-26 13:02:25.5\n");
  const Seen raw = ReadAllOf(Path("image_2"), options);
  EXPECT_NEAR(raw.times[1] - raw.times[0], 0.25, 1e-6);

  WriteText("times.txt", "0\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("has 1 times for 2 pictures"));
  WriteText("times.txt", "0.5\n0.5\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: the time 0.5 is equal to the one"));
  WriteText("times.txt", "0.5\n0.25\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: the time 0.25 does not come after"));
  WriteText("times.txt", "0.5\nsoon\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: 'soon' is no time"));
  options.times = Path("none.txt");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("none.txt"));
}

TEST_F(FileListTest, ListsSayWhatIsWrongWithThem) {
  WritePicture("a.png", 10);
  WritePicture("b.png", 10);
  const auto error = [&](const std::string& text) {
    WriteText("list.txt", text);
    return ErrorOf("list.txt");
  };
  EXPECT_THAT(error("# nothing\n\n"), HasSubstr("the list names no picture"));
  EXPECT_THAT(error("0.1 a.png\n0.2 c.png\n"), HasSubstr("line 2: no such file"));
  EXPECT_THAT(error("0.2 a.png\n0.1 b.png\n"), HasSubstr("line 2: the time 0.1 does not come"));
  EXPECT_THAT(error("0.2 a.png\nb.png\n"), HasSubstr("line 2: some lines have a time"));
  EXPECT_THAT(error("a.png\n0.2 b.png\n"), HasSubstr("line 2: some lines have a time"));
  EXPECT_THAT(error("0.0\n0.1\n"), HasSubstr("line 1: a time without a picture"));
  EXPECT_THAT(error("0.1,a.png\nx,y\n"), HasSubstr("line 2: neither"));
}

// As programs write them: marks of Windows, quotes, further columns, names like numbers.
TEST_F(FileListTest, ListsAreReadAsTheyAreWritten) {
  WritePicture("rgb/1.5.png", 10);
  WritePicture("rgb/2.5.png", 20);
  WritePicture("depth/1.5.png", 90);
  WritePicture("depth/2.5.png", 90);
  const std::vector<std::string> timed = {
      "\xef\xbb\xbf"
      "1.5 rgb/1.5.png\r\n2.5 rgb/2.5.png\r\n",
      "\xef\xbb\xbf"
      "1.5,rgb/1.5.png\r\n2.5,rgb/2.5.png\r\n",
      "timestamp,filename\n\"1.5\",\"rgb/1.5.png\"\n\"2.5\",\"rgb/2.5.png\"\n",
      "timestamp;filename\n1.5;rgb/1.5.png\n2.5;rgb/2.5.png\n",
      "1.5\trgb\\1.5.png\n2.5\trgb\\2.5.png\n",
      "index,file,time\n0,rgb/1.5.png,1.5\n1,rgb/2.5.png,2.5\n",
      "1.5,rgb/1.5.png,0.01,gain\n2.5,rgb/2.5.png,0.02,gain\n",
      "1.5 rgb/1.5.png 1.51 depth/1.5.png\n2.5 rgb/2.5.png 2.51 depth/2.5.png\n",
      "1.51 depth/1.5.png 1.5 rgb/1.5.png\n2.51 depth/2.5.png 2.5 rgb/2.5.png\n",
      "rgb/1.5.png 1.5\nrgb/2.5.png 2.5\n"};
  for (const std::string& text : timed) {
    WriteText("list.csv", text);
    const Seen seen = ReadAllOf(Path("list.csv"));
    EXPECT_THAT(seen.values, ElementsAre(10, 20)) << text;
    EXPECT_THAT(seen.times, ElementsAre(1.5, 2.5)) << text;
    EXPECT_THAT(seen.names, ElementsAre("1.5.png", "2.5.png")) << text;
  }
  EXPECT_THAT(RemarksOf("list.csv"), IsEmpty());
  WriteText("list.csv", timed[7]);
  EXPECT_THAT(RemarksOf("list.csv"), ElementsAre(HasSubstr("2 files in further columns")));
  WriteText("list.txt",
            "\xff\xfe"
            "a");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("UTF-16"));
  WriteText("list.txt", "1.5 depth/1.5.png\n2.5 depth/2.5.png\n");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("lists depth maps"));
}

TEST_F(FileListTest, NamesInListsHaveSpacesAndCommas) {
  for (const char* name : {"2024 trip/001.jpg", "named/a,1.jpg", "named/7 a;b,\"2\".jpg"}) {
    WritePicture(name, 10);
    WriteText("list.txt", std::string(name) + "\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.0)) << name;
    WriteText("list.txt", "0.25 " + std::string(name) + "\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.25)) << name;
    WriteText("list.txt", std::string(name) + ",0.25\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.25)) << name;
  }
}

// The names of pictures become names of masks, so none may lead out of a folder.
TEST_F(FileListTest, NamesOfPicturesAboveTheListAreRelativeToTheirOwnFolder) {
  WritePicture("images/1.png", 10);
  WritePicture("images/more/2.png", 20);
  fs::create_directories(Path("lists"));
  WriteText("lists/all.txt", "../images/1.png\n" + Path("images/more/2.png") + "\n");
  EXPECT_THAT(ReadAllOf(Path("lists/all.txt")).names, ElementsAre("1.png", "more/2.png"));
}

TEST_F(FileListTest, TimesInOtherUnitsAreRefusedByName) {
  for (const char* name : {"0.png", "1.png", "2.png"}) WritePicture(name, 10);
  const auto error = [&](double first, double step) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      text += std::to_string(static_cast<int64_t>(first + i * step)) + "," + std::to_string(i) +
              ".png\n";
    }
    WriteText("list.csv", text);
    return ErrorOf("list.csv");
  };
  EXPECT_THAT(error(1305031452791.0, 67.0), HasSubstr("they seem to be milliseconds"));
  EXPECT_THAT(error(1305031452791720.0, 66667.0), HasSubstr("they seem to be microseconds"));
  EXPECT_THAT(error(0.0, 66666667.0), HasSubstr("they seem to be nanoseconds"));
  EXPECT_THAT(error(1305031452.0, 5.0), "");
  WriteText("list.txt", "0.000000 0.png\n0.000000 1.png\n");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("line 2: the time 0 is equal to the one before it"));
}

}  // namespace
}  // namespace egosieve::vision
