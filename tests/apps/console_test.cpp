// What the command shows: progress, errors, tables, reports.
#include <catch2/catch.hpp>
#include <cstdio>

#include "apps/tetloom/console.hpp"
#include "apps/tetloom/exit_status.hpp"
#include "apps/tetloom/progress_display.hpp"
#include "apps/tetloom/report.hpp"
#include "apps/tetloom/text_table.hpp"

using namespace tetloom;
using namespace tetloom::app;

TEST_CASE("a bar shows the stage, the share done, the rate and the time left") {
  const std::string bar = render_bar({Stage::Faces, 50, 100, 10}, 100);
  CHECK_THAT(bar, Catch::StartsWith("faces"));
  CHECK_THAT(bar, Catch::Contains("[####################....................]"));
  CHECK_THAT(bar, Catch::Contains("50/100") && Catch::Contains("5/s") && Catch::Contains("10.0 s left"));
}

TEST_CASE("a bar never fills the last column of the terminal") {
  for (int width = 1; width < 200; ++width) {
    CAPTURE(width);
    CHECK(static_cast<int>(render_bar({Stage::Intersections, 123'456, 9'999'999, 77}, width).size()) < width);
  }
}

TEST_CASE("a stage of unknown length shows what is done and for how long") {
  const std::string bar = render_bar({Stage::Volume, 1'200'000, 0, 4}, 80);
  CHECK_THAT(bar, Catch::Contains("1.20M") && Catch::Contains("300k/s") && Catch::Contains("4 s"));
  CHECK_THAT(bar, !Catch::Contains("["));
  CHECK(render_line({Stage::Read, 0, 0, 3}) == "read: 3 s");
  CHECK(render_line({Stage::Faces, 12, 40, 2}) == "faces: 12 of 40, 6/s, 5.00 s left");
}

TEST_CASE("a stage whose first item takes long shows for how long") {
  CHECK_THAT(render_bar({Stage::Volume, 0, 1, 12.3}, 80), Catch::EndsWith("0/1  12 s"));
  CHECK(render_line({Stage::Volume, 0, 1, 12.3}) == "volume: 0 of 1, 12 s");
}

TEST_CASE("more done than announced does not overflow the bar") {
  CHECK_THAT(render_bar({Stage::Faces, 300, 100, 10}, 100), Catch::Contains("[" + std::string(40, '#') + "]"));
}

TEST_CASE("a log gets one line per stage and no control characters") {
  std::FILE* file = std::tmpfile();
  {
    ProgressDisplay display(file, ProgressDisplay::Style::Lines);
    // Edges and faces come twice, as in a run that has to make the surface anew.
    for (const Stage stage : {Stage::Read, Stage::Edges, Stage::Faces, Stage::Edges, Stage::Faces}) {
      for (std::uint64_t i = 0; i < 1000; ++i) display.update({stage, {}, i, 1000});
      std::this_thread::sleep_for(std::chrono::milliseconds(150));
    }
  }
  std::rewind(file);
  std::string text(1000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  CHECK(text.find_first_of("\r\033") == std::string::npos);
  CHECK(std::count(text.begin(), text.end(), '\n') == 3);
  CHECK_THAT(text, Catch::Contains("read") && Catch::Contains("edges") && Catch::Contains("faces"));
}

TEST_CASE("a silent display prints nothing") {
  std::FILE* file = std::tmpfile();
  {
    ProgressDisplay display(file, ProgressDisplay::Style::Silent);
    display.update({Stage::Read, {}, 0, 0});
  }
  CHECK(std::ftell(file) == 0);
  std::fclose(file);
}

TEST_CASE("an error shows its entities and its point") {
  const Diagnostic error{ErrorCode::FaceFailed,
                         "the face folds over itself",
                         {{ModelEntity(2, 16), "flange"}, {ModelEntity(1, 4), ""}},
                         Vec3{1, 2.5, -3},
                         {}};
  CHECK(render_diagnostic("error", error) ==
        "error: the face folds over itself\n  on face 17 'flange', edge 5\n  near (1, 2.5, -3)\n");
}

TEST_CASE("an error on hundreds of entities shows a few and counts the others") {
  Diagnostic error{ErrorCode::OpenShell, "holes", {}, {}, {}};
  for (std::uint32_t i = 0; i < 100; ++i) error.entities.push_back({ModelEntity(2, i), ""});
  CHECK_THAT(render_diagnostic("error", error), Catch::Contains("face 12 and 88 more"));
}

TEST_CASE("a histogram shows even a single element") {
  const std::array<std::size_t, 3> bins{0, 1, 1'000'000};
  const std::string text = render_histogram(bins.data(), bins.size(), 0, 1);
  CHECK(std::count(text.begin(), text.end(), '\n') == 3);
  CHECK_THAT(text, Catch::Contains("1,000,000  " + std::string(40, '#')));
  CHECK_THAT(text, Catch::Contains(" 1  .\n"));
}

TEST_CASE("a table leaves out empty columns and says what it does not show") {
  const std::string text =
      render_table({"a", "empty", "name"}, {{"1", "", "Schlüssel"}, {"2", "", "x"}, {"3", "", "y"}}, 2);
  CHECK(text == "    a  name\n    1  Schlüssel\n    2  x\n    … and 1 more\n");
}

TEST_CASE("a colour is shown in sRGB") {
  CHECK(format_color(std::nullopt).empty());
  CHECK(format_color(Color{1, 0, 0}) == "#ff0000");
  CHECK(format_color(Color{0.2158605f, 0.2158605f, 2}) == "#8080ff");
}

TEST_CASE("every error code has its exit status") {
  CHECK(exit_status(ErrorCode::InvalidArgument) == ExitStatus::WrongUsage);
  CHECK(exit_status(ErrorCode::InputUnreadable) == ExitStatus::BadInput);
  CHECK(exit_status(ErrorCode::InputUnsuitable) == ExitStatus::BadInput);
  for (const ErrorCode code : {ErrorCode::EdgeFailed, ErrorCode::FaceFailed, ErrorCode::SelfIntersection,
                               ErrorCode::OpenShell, ErrorCode::VolumeFailed, ErrorCode::WorkerFailed}) {
    CHECK(exit_status(code) == ExitStatus::NotMeshed);
  }
  CHECK(exit_status(ErrorCode::Cancelled) == ExitStatus::Cancelled);
  CHECK(exit_status(ErrorCode::OutOfMemory) == ExitStatus::OutOfResources);
  CHECK(exit_status(ErrorCode::OutputFailed) == ExitStatus::OutOfResources);
}

TEST_CASE("a report of a failure has every member, and null for what was not reached") {
  RunReport report;
  report.input = "part.step";
  add_failure(report, {ErrorCode::FaceFailed, "bad", {{ModelEntity(2, 16), "flange"}}, Vec3{1, 2, 3}, {7}});
  const auto json = nlohmann::json::parse(to_json(report));
  CHECK(json["schema"] == 1);
  CHECK(json["status"] == "failed");
  CHECK(json["counts"] == nlohmann::json({{"points", 0}, {"triangles", 0}, {"tets", 0}, {"regions", 0}}));
  for (const char* key : {"total", "read", "size_field", "surface", "volume", "check", "write"}) {
    CHECK(json["seconds"][key].is_number());
  }
  for (const char* key : {"min_dihedral_deg", "mean_ratio_min", "mean_ratio_p1", "mean_ratio_mean", "edges_in_band"}) {
    CHECK(json["quality"].at(key).is_null());
  }
  CHECK(json["volume"]["mesh"].is_null());
  CHECK(json["volume"]["model"].is_null());
  CHECK(json["digest"].is_null());
  CHECK(json["peak_bytes"] > 1'000'000);
  CHECK(json["errors"][0]["code"] == "face_failed");
  CHECK(json["errors"][0]["entities"][0] == nlohmann::json({{"dim", 2}, {"id", 17}, {"name", "flange"}}));
  CHECK(json["errors"][0]["point"] == nlohmann::json({1, 2, 3}));
  CHECK(json["warnings"].empty());
}

TEST_CASE("names that are no UTF-8 do not spoil a report") {
  RunReport report;
  add_failure(report, {ErrorCode::Internal, "Schl\xfcssel", {}, {}, {}});
  CHECK_NOTHROW(nlohmann::json::parse(to_json(report)));
}

TEST_CASE("the first failure decides the exit status") {
  RunReport report;
  add_failure(report, {ErrorCode::Cancelled, "", {}, {}, {}});
  add_failure(report, {ErrorCode::OutputFailed, "", {}, {}, {}});
  CHECK(report.status == ExitStatus::Cancelled);
  CHECK(report_status(report.status) == "cancelled");
}
