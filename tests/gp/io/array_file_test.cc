#include "gp/io/array_file.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

ArrayMap SomeArrays() {
  ArrayMap arrays;
  arrays["doubles"] = {{2, 3}, std::vector<double>{1.5, -0.0, 3e300, 4, 5e-324, 6}};
  arrays["integers"] = {{3}, std::vector<int64_t>{-1, 0, std::numeric_limits<int64_t>::max()}};
  arrays["bytes"] = {{4}, std::vector<uint8_t>{0, 255, 'a', '\n'}};
  arrays["nothing"] = {{0, 6}, std::vector<double>{}};
  return arrays;
}

void ExpectEqual(const ArrayMap& a, const ArrayMap& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, array] : a) {
    const auto found = b.find(name);
    ASSERT_NE(found, b.end()) << name;
    EXPECT_EQ(array.shape, found->second.shape) << name;
    EXPECT_EQ(array.elements, found->second.elements) << name;
  }
}

std::string SomeBytes() { return Value(SerializeArrays(SomeArrays())); }

TEST(ArrayFile, ReadsWhatItWrites) {
  const std::string bytes = SomeBytes();
  const auto arrays = Value(ParseArrays(bytes));
  ExpectEqual(arrays, SomeArrays());
  EXPECT_EQ(bytes, SomeBytes());
}

// The bytes are those of the contents: no time, no time zone.
TEST(ArrayFile, WritesTheSameBytesAtAnyTime) {
  const std::string bytes = SomeBytes();
  setenv("TZ", "Pacific/Auckland", 1);
  setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  tzset();
  EXPECT_EQ(bytes, SomeBytes());
  unsetenv("SOURCE_DATE_EPOCH");
  unsetenv("TZ");
  tzset();
  EXPECT_THAT(bytes, testing::HasSubstr(std::string("\0\0\x21\0", 4)));
}

TEST(ArrayFile, NoArraysAreNoFile) {
  EXPECT_EQ(SerializeArrays({}).status().code(), absl::StatusCode::kFailedPrecondition);
  const std::string empty_archive = "PK\x05\x06" + std::string(18, '\0');
  EXPECT_EQ(ParseArrays(empty_archive).status().code(), absl::StatusCode::kDataLoss);
}

TEST(ArrayFile, WritesNoMoreArraysThanItReads) {
  ArrayMap arrays;
  for (int64_t i = 0; i < kMaxArraysInFile; ++i) {
    arrays["array_" + std::to_string(i)] = VectorArray<int64_t>({i});
  }
  const auto bytes = Value(SerializeArrays(arrays));
  const auto read = Value(ParseArrays(bytes));
  ExpectEqual(read, arrays);
  arrays["one more"] = VectorArray<int64_t>({0});
  EXPECT_EQ(SerializeArrays(arrays).status().code(), absl::StatusCode::kFailedPrecondition);
}

// Runs Python with the path of a file in the place of sys.argv[1].
bool Python(const std::string& program, const std::string& path) {
  const std::string file = path + ".py";
  std::ofstream(file) << program;
  return std::system(("python3 '" + file + "' '" + path + "'").c_str()) == 0;
}

bool HasNumPy() { return std::system("python3 -c 'import numpy' > /dev/null 2>&1") == 0; }

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// An independent reader of zip archives and of their checksums, where Python is installed.
TEST(ArrayFile, IsAZipArchiveForOthers) {
  const std::string path = testing::TempDir() + "/arrays.npz";
  std::ofstream(path, std::ios::binary) << SomeBytes();
  if (std::system("python3 -c pass > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
  EXPECT_TRUE(Python(R"(
import sys, zipfile, struct
z = zipfile.ZipFile(sys.argv[1])
assert z.testzip() is None
assert z.namelist() == ['bytes.npy', 'doubles.npy', 'integers.npy', 'nothing.npy']
assert all(i.compress_type == 0 and i.date_time == (1980, 1, 1, 0, 0, 0) for i in z.infolist())
d = z.read('doubles.npy')
assert d[:8] == b'\x93NUMPY\x01\x00'
h = struct.unpack('<H', d[8:10])[0]
assert (10 + h) % 64 == 0
assert eval(d[10:10 + h]) == {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3)}
assert struct.unpack('<6d', d[10 + h:])[3] == 4.0
)",
                     path));
}

TEST(ArrayFile, NumPyReadsItAndIsRead) {
  if (!HasNumPy()) GTEST_SKIP() << "no NumPy";
  const std::string path = testing::TempDir() + "/numpy.npz";
  std::ofstream(path, std::ios::binary) << SomeBytes();
  ASSERT_TRUE(Python(R"(
import sys, numpy
arrays = dict(numpy.load(sys.argv[1]))
assert arrays['doubles'].shape == (2, 3) and arrays['doubles'][1, 0] == 4
assert arrays['nothing'].shape == (0, 6) and arrays['bytes'].tobytes() == b'\x00\xffa\n'
numpy.savez(sys.argv[1], **arrays)
)",
                     path));
  const auto read = Value(ParseArrays(Contents(path)));
  ExpectEqual(read, SomeArrays());
  ASSERT_TRUE(
      Python("import sys, numpy; numpy.savez_compressed(sys.argv[1], a=numpy.zeros(1000))", path));
  EXPECT_EQ(ParseArrays(Contents(path)).status().code(), absl::StatusCode::kUnimplemented);
}

TEST(ArrayFile, EveryTruncationIsAnError) {
  const std::string bytes = SomeBytes();
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(ParseArrays(bytes.substr(0, size)).status().code(), absl::StatusCode::kDataLoss)
        << size;
  }
}

TEST(ArrayFile, EveryDamagedByteIsAnErrorOrHarmless) {
  const std::string bytes = SomeBytes();
  std::mt19937_64 generator(1);
  int errors = 0;
  for (size_t place = 0; place < bytes.size(); ++place) {
    std::string damaged = bytes;
    damaged[place] = static_cast<char>(damaged[place] ^ (1 + generator() % 255));
    const auto arrays = ParseArrays(damaged);
    errors += !arrays.ok();
    // Bytes that nobody reads (times, attributes) may differ; names may; contents may not.
    if (arrays.ok()) {
      for (const auto& [name, array] : *arrays) {
        bool known = false;
        for (const auto& [other_name, other] : SomeArrays()) {
          known = known || (other.shape == array.shape && other.elements == array.elements);
        }
        EXPECT_TRUE(known) << "byte " << place << " changed " << name;
      }
    }
  }
  EXPECT_GT(errors, static_cast<int>(bytes.size()) / 2);
}

TEST(ArrayFile, NoiseIsAnError) {
  std::mt19937_64 generator(2);
  const std::string bytes = SomeBytes();
  for (int round = 0; round < 20000; ++round) {
    std::string noise = bytes;
    const int changes = 1 + static_cast<int>(generator() % 40);
    for (int i = 0; i < changes; ++i) {
      noise[generator() % noise.size()] = static_cast<char>(generator());
    }
    (void)ParseArrays(noise);  // no crash, no report of a sanitizer
  }
}

// Huge numbers where lengths and shapes stand must not become allocations.
TEST(ArrayFile, HugeLengthsAreErrors) {
  std::string bytes = SomeBytes();
  const size_t shape = bytes.find("(2, 3)");
  ASSERT_NE(shape, std::string::npos);
  bytes.replace(shape, 16, "(99999999999999)");
  EXPECT_FALSE(ParseArrays(bytes).ok());
  for (const size_t field : {10u, 12u, 16u}) {  // counts and the offset, in the end's record
    std::string other = SomeBytes();
    const size_t end = other.size() - 22;
    for (int i = 0; i < 2; ++i) other[end + field + i] = '\xFF';
    EXPECT_EQ(ParseArrays(other).status().code(), absl::StatusCode::kDataLoss) << field;
  }
}

// The same bytes named by many entries would cost memory many times.
TEST(ArrayFile, MembersThatLieOverEachOtherAreAnError) {
  ArrayMap arrays;
  arrays["a"] = arrays["b"] = {{3}, std::vector<double>{1, 2, 3}};
  std::string bytes = *SerializeArrays(arrays);
  const size_t end = bytes.size() - 22;
  size_t directory = 0;
  std::memcpy(&directory, &bytes[end + 16], 4);
  const size_t second = directory + (end - directory) / 2;  // both entries are of one size
  for (int i = 0; i < 4; ++i) bytes[second + 42 + i] = bytes[directory + 42 + i];
  const auto read = ParseArrays(bytes);
  EXPECT_EQ(read.status().code(), absl::StatusCode::kDataLoss) << read.status();
}

// A member whose contents are the headers and contents of others: with n members in each other, the
// memory would grow as n^2.
TEST(ArrayFile, MembersWithinEachOtherAreAnError) {
  if (std::system("python3 -c pass > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
  const std::string path = testing::TempDir() + "/nested.npz";
  ASSERT_TRUE(Python(R"(
import struct, sys, zlib
header = "{'descr': '|u1', 'fortran_order': False, 'shape': (%d,), }".ljust(117)
body, directory, members = b'', b'', []
for i in range(200):
    text = (header % len(body)).encode()[:117] + b'\n'
    body = b'\x93NUMPY\x01\x00' + struct.pack('<H', len(text)) + text + body
    name, crc, size = b'%d.npy' % i, zlib.crc32(body), len(body)
    fields = struct.pack('<HHHHHIIIHH', 20, 0, 0, 0, 33, crc, size, size, len(name), 0)
    body = struct.pack('<I', 0x04034b50) + fields + name + body
    members.append((fields, name, len(body)))
for fields, name, size in members:
    place = struct.pack('<HHHII', 0, 0, 0, 0, len(body) - size)
    directory += struct.pack('<IH', 0x02014b50, 20) + fields + place + name
end = struct.pack('<IHHHHIIH', 0x06054b50, 0, 0, 200, 200, len(directory), len(body), 0)
open(sys.argv[1], 'wb').write(body + directory + end)
)",
                     path));
  EXPECT_THAT(ParseArrays(Contents(path)),
              IsError(absl::StatusCode::kDataLoss, "larger than the file"));
}

// A header's signature in the last bytes before the directory, without the rest of it.
TEST(ArrayFile, AMembersHeaderThatIsCutOffIsNone) {
  std::vector<uint8_t> elements(64, 0);
  const uint8_t signature[] = {'P', 'K', 3, 4};
  std::copy(std::begin(signature), std::end(signature), elements.end() - 8);
  std::string bytes = *SerializeArrays({{"a", {{64}, elements}}});
  uint32_t directory = 0;
  std::memcpy(&directory, &bytes[bytes.size() - 22 + 16], sizeof(directory));
  const uint32_t place = directory - 8;
  std::memcpy(&bytes[directory + 42], &place, sizeof(place));
  EXPECT_EQ(ParseArrays(bytes).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace egosieve::gp
