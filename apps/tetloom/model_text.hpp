#pragma once
// A model as `info` describes it.
#include <string>

#include <nlohmann/json.hpp>

#include "tetloom/model.hpp"

namespace tetloom::app {

/// Format, units, box, counts, healing, and tables of the regions, faces and named edges.
std::string render_model(const ModelDocument& document, const std::string& path);

/// The same as JSON, with all entities.
nlohmann::ordered_json model_json(const ModelDocument& document);

}  // namespace tetloom::app
