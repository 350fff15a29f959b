#include "core/sizing/size_field.hpp"

namespace tetloom {

SizeField SizeField::uniform(double size) {
  SizeField field;
  field.smallest_ = field.largest_ = size;
  return field;
}

double SizeField::size_at(const Vec3&) const { return smallest_; }

}  // namespace tetloom
