// Pictures: glowworm/picture.h.
#include "glowworm/picture.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <strings.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"

namespace glowworm::python {

namespace {

using api::Picture;

bool contains(const Picture& picture, const std::string& name) {
  return std::any_of(picture.layers.begin(), picture.layers.end(),
                     [&](const auto& layer) { return layer.name == name; });
}

/// A layer as an array that keeps the picture alive: (height, width, channels), or (height, width) of one channel.
py::array layer_array(const py::object& self, const std::string& name) {
  const auto& picture = self.cast<const Picture&>();
  for (const Picture::Layer& layer : picture.layers)
    if (layer.name == name) {
      std::vector<py::ssize_t> shape{picture.height, picture.width};
      if (layer.channels.size() != 1) shape.push_back(static_cast<py::ssize_t>(layer.channels.size()));
      return view(layer.samples.data(), shape, self, true);
    }
  try {
    picture.layer(name);
  } catch (const std::exception& error) {
    throw py::key_error(error.what());
  }
  throw py::key_error(name);
}

/// Letters of the channels of a layer of so many.
std::string letters(py::ssize_t channels, const std::string& name) {
  static const char* const known[] = {"Z", "UV", "RGB", "RGBA"};
  if (channels == 1 && name == "alpha") return "A";
  if (channels < 1 || channels > 4)
    throw py::value_error("layer '" + name + "' has " + std::to_string(channels) + " channels; expected 1 to 4");
  return known[channels - 1];
}

/// A grey image as red, green and blue.
std::vector<float> rgb_of(const std::vector<float>& grey) {
  std::vector<float> out;
  out.reserve(3 * grey.size());
  for (const float value : grey) out.insert(out.end(), {value, value, value});
  return out;
}

std::shared_ptr<Picture> picture_of(const py::dict& layers) {
  auto out = std::make_shared<Picture>();
  for (const auto& [key, value] : layers) {
    const auto name = key.cast<std::string>();
    const Floats array = floats(value, name.c_str(), Check::later);  // nothing seen: an infinite depth
    if (array.ndim() != 2 && array.ndim() != 3)
      throw py::value_error("layer '" + name + "' has " + std::to_string(array.ndim()) +
                            " axes; expected (height, width) or (height, width, channels)");
    const auto height = static_cast<int>(array.shape(0)), width = static_cast<int>(array.shape(1));
    if (!out->layers.empty() && (height != out->height || width != out->width))
      throw py::value_error("layer '" + name + "' has another size than the others");
    out->height = height;
    out->width = width;
    const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
    Picture::Layer layer{name, letters(channels, name), {array.data(), array.data() + array.size()}};
    if (channels == 1 && name == api::kImageLayer) {
      layer.channels = "RGB";
      layer.samples = rgb_of(layer.samples);
    }
    out->layers.push_back(std::move(layer));
  }
  if (out->layers.empty()) throw py::value_error("a picture needs a layer");
  return out;
}

/// A picture as Python pickles it, with the attributes that Python gave it.
py::tuple state_of(const py::object& self) {
  const auto& p = self.cast<const Picture&>();
  py::list layers;
  for (const Picture::Layer& layer : p.layers)
    layers.append(
        py::make_tuple(layer.name, layer.channels, Floats(py::ssize_t(layer.samples.size()), layer.samples.data())));
  return py::make_tuple(p.width, p.height, p.x0, p.y0, p.whole_width, p.whole_height, layers, p.metadata,
                        self.attr("__dict__"));
}

std::pair<std::shared_ptr<Picture>, py::dict> picture_of_state(const py::tuple& state) {
  if (state.size() != 9) throw py::value_error("this is not a pickled picture");
  auto p = std::make_shared<Picture>();
  int* const numbers[] = {&p->width, &p->height, &p->x0, &p->y0, &p->whole_width, &p->whole_height};
  for (std::size_t i = 0; i < std::size(numbers); ++i) *numbers[i] = state[i].cast<int>();
  for (const py::handle entry : state[6]) {
    const auto layer = entry.cast<py::tuple>();
    const Floats samples = floats(layer[2], "samples", Check::later);
    p->layers.push_back({layer[0].cast<std::string>(),
                         layer[1].cast<std::string>(),
                         {samples.data(), samples.data() + samples.size()}});
  }
  p->metadata = state[7].cast<std::map<std::string, std::string>>();
  return {std::move(p), state[8].cast<py::dict>()};
}

py::dict comparison(const Picture& picture, const Picture& reference, const std::string& layer, double leave_out) {
  api::Comparison c;
  {
    const py::gil_scoped_release release;
    c = api::compare(picture, reference, layer, leave_out);
  }
  py::dict out;
  out["mse"] = c.mse;
  out["relative_mse"] = c.relative_mse;
  out["relative_rmse"] = c.relative_rmse;
  out["psnr_db"] = c.psnr_db;
  out["luminance_ratio"] = c.luminance_ratio;
  out["rgb_ratio"] = py::make_tuple(c.rgb_ratio[0], c.rgb_ratio[1], c.rgb_ratio[2]);
  out["largest_difference"] = c.largest_difference;
  out["pixels"] = c.pixels;
  out["pixels_not_finite"] = c.pixels_not_finite;
  return out;
}

py::bytes png(const Picture& picture, const std::string& layer, std::optional<float> exposure) {
  std::string bytes;
  {
    const py::gil_scoped_release release;
    const bool chooses = !exposure && contains(picture, api::kImageLayer);
    bytes = api::png_of(picture, layer, chooses ? api::automatic_exposure(picture) : exposure.value_or(0));
  }
  return bytes;
}

}  // namespace

void bind_picture(py::module_& module) {
  const auto release = py::call_guard<py::gil_scoped_release>();
  py::class_<Picture, std::shared_ptr<Picture>>(
      module, "Picture",
      "A picture: layers of 32-bit floats. picture['image'] is radiance in W sr^-1 m^-2, linear RGB (Rec. 709), as an\n"
      "array of shape (height, width, 3); the other layers are the AOVs asked for. Arrays are views of the picture's\n"
      "memory and keep it alive.",
      py::dynamic_attr())
      .def(py::init(&picture_of), py::arg("layers"),
           "Copies arrays of shape (height, width) or (height, width, channels), by name. A grey image becomes one\n"
           "of equal red, green and blue.")
      .def_static(
          "read",
          [](const std::filesystem::path& path) { return std::make_shared<Picture>(api::read_picture(path.string())); },
          py::arg("path"), release, "Reads any image file that the command line reads.")
      .def(
          "write",
          [](const Picture& self, const std::filesystem::path& path, std::optional<float> exposure,
             const std::string& precision) {
            // The case of the ending does not matter to the writer, either.
            const bool is_png = strcasecmp(path.extension().c_str(), ".png") == 0;
            const auto chosen = choice<api::Precision>("precision", precision, {"half", "float"});
            const py::gil_scoped_release unlocked;
            const float stops = !exposure && is_png ? api::automatic_exposure(self) : exposure.value_or(0);
            api::write_picture(path.string(), self, stops, chosen);
          },
          py::arg("path"), py::arg("exposure") = py::none(), py::arg("precision") = "float",
          "Writes .exr with all layers, linear, or .png with the image and a filmic tone curve. exposure: stops of a\n"
          ".png; None: automatic_exposure. precision: of an .exr, 'float' (32 bits) or 'half' (16 bits).")
      .def(py::pickle(&state_of, &picture_of_state))
      .def_readonly("width", &Picture::width, "Pixels.")
      .def_readonly("height", &Picture::height, "Pixels.")
      .def_property_readonly(
          "place", [](const Picture& p) { return py::make_tuple(p.x0, p.y0, p.whole_width, p.whole_height); },
          "x0, y0, width and height of the whole, in pixels, of a part of a picture; else zeros.")
      .def_readonly("metadata", &Picture::metadata, "Settings, version and time of a render.")
      .def(
          "keys",
          [](const Picture& self) {
            std::vector<std::string> names;
            for (const Picture::Layer& layer : self.layers) names.push_back(layer.name);
            return names;
          },
          "Names of the layers.")
      .def(
          "channels", [](const Picture& self, const std::string& name) { return self.layer(name).channels; },
          py::arg("layer") = api::kImageLayer, "Letters of the channels of a layer: 'RGB', 'XYZ', 'Z'.")
      .def("__getitem__", &layer_array, py::arg("layer"))
      .def("__contains__", &contains, py::arg("layer"))
      .def_property_readonly(
          "image", [](const py::object& self) { return layer_array(self, api::kImageLayer); }, "The layer 'image'.")
      .def("png", &png, py::arg("layer") = api::kImageLayer, py::arg("exposure") = py::none(),
           "The bytes of a PNG file of a layer, with a filmic tone curve. exposure: stops; None: automatic_exposure,\n"
           "or 0 where there is no image.")
      .def("_repr_png_",
           [](const Picture& self) -> py::object {
             if (!contains(self, api::kImageLayer)) return py::none();
             return png(self, api::kImageLayer, std::nullopt);
           })
      .def_property_readonly(
          "statistics", [](const py::object& self) { return py::getattr(self, "_statistics", py::dict()); },
          "Settings, counts and times of the render; the guide lists the keys. Empty for other pictures.")
      .def_property_readonly("automatic_exposure", &api::automatic_exposure, release,
                             "Stops that take the image's mean luminance to 18% grey.");
  module.def("_compare", &comparison, py::arg("picture"), py::arg("reference"), py::arg("layer"), py::arg("leave_out"));
}

}  // namespace glowworm::python
