// Reading what cannot be read: always a clear error, nothing printed, no crash.
#include <catch2/catch.hpp>
#include <cstdio>
#include <functional>
#include <random>

#include "tests/cad/cad_samples.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using test::file_content;
using test::Sample;
using test::TemporaryFolder;
using test::write_file;

namespace {

ErrorCode code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK_FALSE(error.diagnostic().message.empty());
    return error.code();
  }
  FAIL("no error was thrown");
  return ErrorCode::Internal;
}

/// What a piece of code writes to standard output and standard error.
std::string captured_output(const std::function<void()>& call) {
  const TemporaryFolder scratch;
  const std::string file = (scratch / "output").string();
  std::fflush(nullptr);
  const int out = dup(1), err = dup(2);
  FILE* target = std::fopen(file.c_str(), "w");
  dup2(fileno(target), 1);
  dup2(fileno(target), 2);
  try {
    call();
  } catch (const Error&) {  // the errors of bad files are tested elsewhere
  }
  std::fflush(nullptr);
  dup2(out, 1);
  dup2(err, 2);
  close(out);
  close(err);
  std::fclose(target);
  return file_content(file);
}

}  // namespace

TEST_CASE("missing files, directories, empty files and files of another kind are unreadable") {
  const TemporaryFolder scratch;
  for (const char* extension : {"step", "stp", "iges", "igs", "brep"}) {
    INFO(extension);
    const std::filesystem::path path = scratch / (std::string("file.") + extension);
    CHECK(code_of([&] { read_model(path); }) == ErrorCode::InputUnreadable);
    std::filesystem::create_directory(path);
    CHECK(code_of([&] { read_model(path); }) == ErrorCode::InputUnreadable);
    std::filesystem::remove(path);
    write_file(path, "");
    CHECK(code_of([&] { read_model(path); }) == ErrorCode::InputUnreadable);
    write_file(path, "this is no geometry\n");
    CHECK(code_of([&] { read_model(path); }) == ErrorCode::InputUnreadable);
  }
}

TEST_CASE("a file under the extension of another format is unreadable") {
  const TemporaryFolder scratch;
  test::write_sample(Sample::Box, scratch / "box.step");
  test::write_sample(Sample::Box, scratch / "box.igs");
  test::write_sample(Sample::Box, scratch / "box.brep");
  for (const char* content : {"box.step", "box.igs", "box.brep"}) {
    for (const char* name : {"as.step", "as.igs", "as.brep"}) {
      if (std::string(content).substr(4) == std::string(name).substr(3)) continue;
      INFO(content << " " << name);
      std::filesystem::copy_file(scratch / content, scratch / name, std::filesystem::copy_options::overwrite_existing);
      CHECK(code_of([&] { read_model(scratch / name); }) == ErrorCode::InputUnreadable);
    }
  }
}

TEST_CASE("truncated files are unreadable wherever they are cut") {
  const TemporaryFolder scratch;
  for (const char* name : {"cut.step", "cut.igs", "cut.brep"}) {
    test::write_sample(Sample::DrilledBox, scratch / name);
    const std::string whole = file_content(scratch / name);
    for (int i = 1; i < 40; ++i) {
      const std::size_t length = whole.size() * static_cast<std::size_t>(i) / 40;
      INFO(name << " cut after " << length << " of " << whole.size() << " bytes");
      write_file(scratch / name, whole.substr(0, length));
      CHECK(code_of([&] { read_model(scratch / name); }) == ErrorCode::InputUnreadable);
    }
  }
}

TEST_CASE("a STEP file with two entities of one name is refused by that name") {
  const TemporaryFolder scratch;
  test::write_sample(Sample::DrilledBox, scratch / "twice.step");
  std::string bytes = file_content(scratch / "twice.step");
  const std::size_t at = bytes.find("#12 =");
  REQUIRE(at != std::string::npos);
  // A name in a string or a comment, and a mere reference, are no second entity.
  bytes.insert(at, "/* #12 = ; */ #90001 = CARTESIAN_POINT('it''s; #12 = x',(0.,0.,0.));\n");
  write_file(scratch / "twice.step", bytes);
  CHECK_NOTHROW(read_model(scratch / "twice.step"));
  bytes.insert(at, "#12 = PLANE('',#13);\n");
  write_file(scratch / "twice.step", bytes);
  try {
    read_model(scratch / "twice.step");
    FAIL("no error was thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::InputUnreadable);
    CHECK(error.diagnostic().message.find("two entities are #12") != std::string::npos);
  }
}

TEST_CASE("an item of an unknown kind is left out of a part's shapes, and is damage elsewhere") {
  const TemporaryFolder scratch;
  test::write_sample(Sample::DrilledBox, scratch / "box.step");
  const std::string bytes = file_content(scratch / "box.step");
  const auto write_with_item_in = [&](const std::string& list) {
    std::string changed = bytes;
    const std::size_t at = changed.find("(#", changed.find(list)), end = changed.find("ENDSEC;", at);
    REQUIRE(end < changed.size());
    changed.insert(end, "#90001 = LEADER_DIRECTED_CALLOUT('',());\n");
    changed.insert(at + 1, "#90001,");
    write_file(scratch / "changed.step", changed);
  };
  write_with_item_in("ADVANCED_BREP_SHAPE_REPRESENTATION");
  const ModelDocument document = read_model(scratch / "changed.step");
  CHECK(document.model->topology().region_count() == 1);
  REQUIRE(document.warnings.size() == 1);
  CHECK_THAT(document.warnings[0].message, Catch::Contains("of an unknown kind and left out"));
  // Nor where something else is wrong with the same list: here its context.
  std::string changed = file_content(scratch / "changed.step");
  const std::size_t list_end = changed.find(")", changed.find("(#90001,"));
  const std::size_t context = changed.find("#", list_end), end = changed.find(")", context);
  changed.replace(context, end - context, "#90001");
  write_file(scratch / "changed.step", changed);
  CHECK(code_of([&] { read_model(scratch / "changed.step"); }) == ErrorCode::InputUnreadable);
  for (const char* list : {"DEFINITIONAL_REPRESENTATION", "GLOBAL_UNIT_ASSIGNED_CONTEXT"}) {
    INFO(list);
    write_with_item_in(list);
    CHECK(code_of([&] { read_model(scratch / "changed.step"); }) == ErrorCode::InputUnreadable);
  }
}

TEST_CASE("random bytes are unreadable") {
  const TemporaryFolder scratch;
  const unsigned seed = 20260101;
  std::printf("random bytes: seed %u\n", seed);
  std::mt19937 random(seed);
  for (const char* name : {"noise.step", "noise.igs", "noise.brep"}) {
    for (const char* head : {"", "ISO-10303-21;\n", "\nCASCADE Topology V1, (c) Matra-Datavision\n"}) {
      std::string bytes = head;
      for (int i = 0; i < 20000; ++i) bytes += static_cast<char>(random() & 255u);
      write_file(scratch / name, bytes);
      CHECK(code_of([&] { read_model(scratch / name); }) == ErrorCode::InputUnreadable);
    }
  }
}

TEST_CASE("damaged files give a model or an error, and never end the process") {
  const TemporaryFolder scratch;
  const unsigned seed = 20260102;
  std::printf("damaged files: seed %u\n", seed);
  std::mt19937 random(seed);
  for (const char* name : {"damaged.step", "damaged.igs", "damaged.brep"}) {
    test::write_sample(Sample::DrilledBox, scratch / name);
    const std::string whole = file_content(scratch / name);
    for (int round = 0; round < 60; ++round) {
      std::string bytes = whole;
      for (int i = 0; i < 1 + round % 8; ++i) bytes[random() % bytes.size()] = "0123456789-+.#$()*' \n"[random() % 21];
      write_file(scratch / name, bytes);
      try {
        const ModelDocument document = read_model(scratch / name);
        CHECK(document.model->topology().face_count() > 0);
      } catch (const Error& error) {
        CHECK_FALSE(error.diagnostic().message.empty());
      }
    }
  }
}

TEST_CASE("files without a face are unsuitable") {
  const TemporaryFolder scratch;
  test::write_step_without_shape(scratch / "empty.step");
  CHECK(code_of([&] { read_model(scratch / "empty.step"); }) == ErrorCode::InputUnsuitable);
  test::write_sample(Sample::NoShape, scratch / "empty.brep");
  CHECK(code_of([&] { read_model(scratch / "empty.brep"); }) == ErrorCode::InputUnsuitable);
}

TEST_CASE("unknown extensions and senseless angles are invalid arguments") {
  CHECK(code_of([] { read_model("model.xyz"); }) == ErrorCode::InvalidArgument);
  CHECK(code_of([] { read_model("model"); }) == ErrorCode::InvalidArgument);
  for (const double angle : {0.0, -1.0, 4.0, std::nan("")}) {
    ReadOptions options;
    options.feature_angle = angle;
    CHECK(code_of([&] { read_model("model.step", options); }) == ErrorCode::InvalidArgument);
  }
}

TEST_CASE("a raised cancel token stops the reading") {
  const TemporaryFolder scratch;
  test::write_sample(Sample::DrilledBox, scratch / "box.step");
  CancelToken token;
  token.cancel();
  CHECK(code_of([&] { read_model(scratch / "box.step", {}, &token); }) == ErrorCode::Cancelled);
}

TEST_CASE("reading prints nothing") {
  const TemporaryFolder scratch;
  for (const char* name : {"box.step", "box.igs", "box.brep"}) {
    test::write_sample(Sample::DrilledBox, scratch / name);
    CHECK(captured_output([&] { read_model(scratch / name); }).empty());
    std::string bytes = file_content(scratch / name);
    for (std::size_t i = bytes.size() / 3; i < bytes.size() / 3 + 40; ++i) bytes[i] = '9';
    write_file(scratch / name, bytes);
    CHECK(captured_output([&] { read_model(scratch / name); }).empty());
  }
  write_file(scratch / "junk.step", "ISO-10303-21; junk END-ISO-10303-21;");
  CHECK(captured_output([&] { read_model(scratch / "junk.step"); }).empty());
}
