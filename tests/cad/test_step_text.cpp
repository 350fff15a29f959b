// The records of STEP files, and that OpenCASCADE makes the same of them as of what its own parser finds.
#include <catch2/catch.hpp>
#include <Interface_InterfaceModel.hxx>
#include <sstream>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_CartesianPoint.hxx>
#include <TCollection_HAsciiString.hxx>
#include <XSControl_WorkSession.hxx>

#include "core/cad/detail/step_library.hpp"
#include "core/cad/detail/step_text.hpp"
#include "tests/cad/cad_samples.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace tetloom;
using cad::parse_step_text;
using test::Sample;

namespace {

std::string file_with(const std::string& data, const std::string& header = "FILE_SCHEMA(('CONFIG'));\n") {
  return "ISO-10303-21;\nHEADER;\n" + header + "ENDSEC;\nDATA;\n" + data + "ENDSEC;\nEND-ISO-10303-21;\n";
}

/// "ident type(argument,…)" for every record after the header.
std::vector<std::string> records_of(const std::string& data) {
  const auto text = parse_step_text(file_with(data));
  REQUIRE(text);
  std::vector<std::string> result;
  for (std::size_t i = text->header_count; i < text->records.size(); ++i) {
    const cad::StepRecord& record = text->records[i];
    std::string line = std::string(record.ident) + " " + record.type + "(";
    for (std::uint32_t k = 0; k < record.argument_count; ++k)
      line += (k > 0 ? "|" : "") + std::string(text->arguments[record.first_argument + k].text);
    result.push_back(line + ")");
  }
  return result;
}

std::vector<Interface_ParamType> types_of(const std::string& arguments) {
  const auto text = parse_step_text(file_with("#1=A(" + arguments + ");\n"));
  REQUIRE(text);
  std::vector<Interface_ParamType> types;
  const cad::StepRecord& last = text->records.back();
  for (std::uint32_t k = 0; k < last.argument_count; ++k)
    types.push_back(text->arguments[last.first_argument + k].type);
  return types;
}

/// What a file was loaded to: every entity with its label, type and place.
std::string loaded(const std::filesystem::path& path, const Handle(IFSelect_WorkLibrary) & library) {
  STEPControl_Reader reader;
  if (!library.IsNull()) reader.WS()->SetLibrary(library);
  reader.ReadFile(path.c_str());
  const Handle(Interface_InterfaceModel) model = reader.WS()->Model();
  std::ostringstream out;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(Standard_Transient) entity = model->Value(i);
    out << model->StringLabel(entity)->ToCString() << ' ' << entity->DynamicType()->Name();
    const Handle(StepGeom_CartesianPoint) point = Handle(StepGeom_CartesianPoint)::DownCast(entity);
    for (int k = 1; !point.IsNull() && k <= point->NbCoordinates(); ++k) out << ' ' << point->CoordinatesValue(k);
    const Handle(Interface_Check) check = model->Check(i, true);
    out << ' ' << (check.IsNull() ? 0 : check->NbFails()) << '\n';
  }
  return out.str();
}

}  // namespace

TEST_CASE("a list comes before the record that it is in, and is called by its number") {
  CHECK(records_of("#7 = KNOTS('', (1,2), #3, ((4.,5.E-1),(.T.,$,*)));\n") ==
        std::vector<std::string>{"$1 /* (SUB) */(1|2)", "$3 /* (SUB) */(4.|5.E-1)", "$4 /* (SUB) */(.T.|$|*)",
                                 "$2 /* (SUB) */($3|$4)", "#7 KNOTS(''|$1|#3|$2)"});
  CHECK(records_of("#1=EMPTY();\n#2=TYPED(LENGTH_MEASURE(2.5));\n") ==
        std::vector<std::string>{"#1 EMPTY()", "$1 LENGTH_MEASURE(2.5)", "#2 TYPED($1)"});
}

TEST_CASE("the parts of a complex entity follow each other, the first with its name") {
  CHECK(records_of("#5=(A((1))\nB() C('x'));\n") ==
        std::vector<std::string>{"$1 /* (SUB) */(1)", "#5 A($1)", "#0 B()", "#0 C('x')"});
}

TEST_CASE("comments and blanks are skipped, and texts keep what stands in them") {
  CHECK(records_of("/* one; */ #1\t= /* two */ A ( 'it''s (a, /* text */ b)\nin two lines' , 3 ) ;\r\n") ==
        std::vector<std::string>{"#1 A('it''s (a, /* text */ b)\nin two lines'|3)"});
}

TEST_CASE("arguments have their types") {
  CHECK(types_of("#2,'a',.TRUE.,$,*,-3,+7,1.,-.5,10E5,2.5E-3,\"0FF\",(1)") ==
        std::vector<Interface_ParamType>{
            Interface_ParamIdent, Interface_ParamText, Interface_ParamEnum, Interface_ParamVoid, Interface_ParamMisc,
            Interface_ParamInteger, Interface_ParamInteger, Interface_ParamReal, Interface_ParamReal,
            Interface_ParamReal, Interface_ParamReal, Interface_ParamHexa, Interface_ParamSub});
}

TEST_CASE("whatever is unusual is left to OpenCASCADE's parser") {
  for (const char* data :
       {"#1=A(1,);\n", "#1=A(,1);\n", "#1=A(1 2);\n", "#1=A(1;\n", "#1=A 1);\n", "#=A();\n", "#1 A();\n", "#1=A('x);\n",
        "#1=A(1.5e3);\n", "#1=A(word);\n", "#1=A(.x.);\n", "#1=A(--1);\n", "#1=!OWN();\n", "#1=&SCOPE ENDSCOPE A();\n",
        "#1=(A());B();\n", "/* open #1=A();\n", "#1=A();\nENDSEC;\nDATA;\n#2=B();\n", "#1=A(\"0G\");\n"}) {
    INFO(data);
    CHECK_FALSE(parse_step_text(file_with(data)));
  }
  CHECK_FALSE(parse_step_text(""));
  CHECK_FALSE(parse_step_text("ISO-10303-21;"));
  CHECK_FALSE(parse_step_text("\xEF\xBB\xBF" + file_with("#1=A();\n")));
  CHECK_FALSE(parse_step_text(file_with(std::string("#1=A('\0');\n", 11))));
  const std::string whole = file_with("#1=A('text',(1.5,#2),.T.);\n");
  for (std::size_t length = 0; length + 2 < whole.size(); ++length)
    CHECK_FALSE(parse_step_text(whole.substr(0, length)));
}

TEST_CASE("lists may be nested deeply and be long") {
  const std::string deep = "#1=A(" + std::string(200'000, '(') + std::string(200'000, ')') + ");\n";
  CHECK(parse_step_text(file_with(deep)));
  std::string wide = "#1=A((0";
  for (int i = 0; i < 200'000; ++i) wide += ",1";
  CHECK(parse_step_text(file_with(wide + "));\n")));
}

TEST_CASE("files are loaded as OpenCASCADE loads them") {
  const test::TemporaryFolder scratch;
  std::vector<std::filesystem::path> files{scratch / "gearbox.step", scratch / "inch.step"};
  test::write_gearbox(files[0]);
  test::write_inch_box(files[1]);
  for (const Sample sample :
       {Sample::DrilledBox, Sample::LoftedSolid, Sample::Torus, Sample::SplineSolid, Sample::NoShape}) {
    files.push_back(scratch / ("sample" + std::to_string(files.size()) + ".step"));
    if (sample == Sample::NoShape) {
      test::write_step_without_shape(files.back());
    } else {
      test::write_sample(sample, files.back());
    }
  }
  for (const std::filesystem::path& file : files) {
    INFO(file);
    const std::string expected = loaded(file, {});
    CHECK_FALSE(expected.empty());
    CHECK(loaded(file, new cad::StepLibrary) == expected);
  }
}
