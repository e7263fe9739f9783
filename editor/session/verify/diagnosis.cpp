#include "editor/session/verify/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "base/text.h"
#include "editor/session/settings/light_groups.h"
#include "editor/session/verify/difference.h"
#include "shaders/core/tonemap.glsl"

namespace raygraph::session {

namespace {

constexpr size_t kMostHypotheses = 8, kMostObjects = 16;
constexpr double kLeastExplained = 0.25;
// Freer hypotheses explain more without being right: each further number costs this, and that something is
// off somewhere in an object, without a prediction, costs as much as several.
constexpr double kCostOfNumber = 0.015, kCostOfPlace = 0.15;
// Where a part is all of the light, a factor on it is one on the picture, which is the simpler cause.
constexpr double kCostOfPart = 0.002;

std::string Percent(double share) {
    return Text("{:.0f} %", 100.0 * std::abs(share));
}

// Says what picture = reference + amount * part means.
std::string AmountText(const std::string& part, double amount) {
    if (amount < -0.85) return "the picture lacks " + part;
    if (amount > 0.85 && amount < 1.15) return part + " is twice as strong as it should be";
    return Text("{} is {} too {}", part, Percent(amount), amount < 0.0 ? "weak" : "strong");
}

std::string PartText(const LightPart& part) {
    if (part.kind == "light group") {
        if (part.name == "environment") return "the light of the environment";
        if (part.name == "rest") return "the light of the other lights";
        return Text("the light of group `{}`", part.name);
    }
    if (part.name == "emission") return "emission that is seen directly";
    if (part.kind == "path") return part.name + " light";
    return part.name == "diffuse"    ? "diffuse reflection"
           : part.name == "specular" ? "specular reflection"
                                     : "transmitted light";
}

// Sums products of the weighted difference with a predictor, by color.
struct Products {
    std::array<double, 3> xx{}, xe{};

    void Add(size_t channel, double weight, double x, double e) {
        xx[channel] += weight * x * x;
        xe[channel] += weight * x * e;
    }
    double AmountOfAll() const {
        const double all = xx[0] + xx[1] + xx[2];
        return all > 0.0 ? (xe[0] + xe[1] + xe[2]) / all : 0.0;
    }
    // Returns how much of the squares the best amount takes away: one for all colors, or one each.
    double TakenByOne() const { return AmountOfAll() * (xe[0] + xe[1] + xe[2]); }
    double TakenByColors() const {
        double taken = 0.0;
        for (size_t c = 0; c < 3; ++c) taken += xx[c] > 0.0 ? xe[c] * xe[c] / xx[c] : 0.0;
        return taken;
    }
};

Products ProductsOf(const Residual& residual, const Texels& part) {
    Products products;
    for (size_t i = 0; i < part.size(); ++i)
        if (residual.Weight(i) > 0.0f)
            products.Add(i % 4, residual.Weight(i), part[i], residual.Difference(i));
    return products;
}

// Solves a symmetric positive system by Gauss and Jordan; returns the inverse, and puts the solution in `b`.
// Singular rows give 0.
std::vector<double> Solve(std::vector<double> a, std::vector<double>& b) {
    const size_t n = b.size();
    std::vector<double> inverse(n * n, 0.0);
    for (size_t i = 0; i < n; ++i) {
        inverse[i * n + i] = 1.0;
        a[i * n + i] *= 1.0 + 1e-9;
    }
    for (size_t k = 0; k < n; ++k) {
        const double pivot = a[k * n + k];
        if (!(pivot > 0.0)) {
            for (size_t j = 0; j < n; ++j) inverse[k * n + j] = a[k * n + j] = 0.0;
            continue;
        }
        for (size_t j = 0; j < n; ++j) {
            a[k * n + j] /= pivot;
            inverse[k * n + j] /= pivot;
        }
        for (size_t i = 0; i < n; ++i) {
            const double factor = a[i * n + k];
            if (i == k || factor == 0.0) continue;
            for (size_t j = 0; j < n; ++j) {
                a[i * n + j] -= factor * a[k * n + j];
                inverse[i * n + j] -= factor * inverse[k * n + j];
            }
        }
    }
    std::vector<double> solution(n, 0.0);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j) solution[i] += inverse[i * n + j] * b[j];
    b = std::move(solution);
    return inverse;
}

class Diagnosing {
  public:
    Diagnosing(const Residual& residual, const RenderFile& render, const SceneNames& names, float exposureEv)
        : m_residual(residual), m_render(render), m_names(names), m_scale(std::exp2(exposureEv)) {}

    Diagnosis Run() {
        WeighParts();
        WeighObjects("object", m_render.instance, m_names.instances);
        WeighObjects("material", m_render.material, m_names.materials);
        WeighPicture();
        WeighToneCurves();
        WeighShift();
        Rank(m_diagnosis);
        std::ranges::sort(m_diagnosis.objects, std::greater{}, &ObjectShare::share);
        if (m_diagnosis.objects.size() > kMostObjects) m_diagnosis.objects.resize(kMostObjects);
        return std::move(m_diagnosis);
    }

  private:
    void Add(Hypothesis hypothesis, double cost) {
        hypothesis.score = hypothesis.explained - cost;
        m_diagnosis.hypotheses.push_back(std::move(hypothesis));
    }
    double ExplainedBy(double taken) const { return m_residual.Explained(m_residual.Squares() - taken); }

    // Parts one by one, and all of a kind at once.
    void WeighParts() {
        const std::vector<LightPart> parts = PartsOf(m_render);
        for (const LightPart& part : parts) {
            const Products products = ProductsOf(m_residual, *part.radiance);
            const double amount = products.AmountOfAll();
            Add({part.kind, part.name, AmountText(PartText(part), amount), ExplainedBy(products.TakenByOne()),
                 amount},
                kCostOfPart);
        }
        for (const char* kind : {"path", "lobe", "light group"}) {
            std::vector<LightPart> together;
            for (const LightPart& part : parts)
                if (part.kind == kind || (part.name == "emission" && std::string_view(kind) == "lobe"))
                    together.push_back(part);
            if (together.size() > 1) FitTogether(kind, together);
        }
    }

    void FitTogether(const std::string& kind, const std::vector<LightPart>& parts) {
        const size_t n = parts.size();
        std::vector<double> a(n * n, 0.0), b(n, 0.0), energy(n, 0.0);
        double whole = 0.0;
        for (size_t i = 0; i < m_residual.Reference().size(); ++i) {
            const double weight = m_residual.Weight(i);
            if (!(weight > 0.0)) continue;
            whole += m_residual.Reference()[i];
            for (size_t k = 0; k < n; ++k) {
                const double x = (*parts[k].radiance)[i];
                if (x == 0.0) continue;
                energy[k] += x;
                b[k] += weight * x * m_residual.Difference(i);
                for (size_t l = 0; l <= k; ++l) a[k * n + l] += weight * x * (*parts[l].radiance)[i];
            }
        }
        for (size_t k = 0; k < n; ++k)
            for (size_t l = 0; l < k; ++l) a[l * n + k] = a[k * n + l];
        const std::vector<double> products = b;
        const std::vector<double> inverse = Solve(a, b);
        double taken = 0.0;
        for (size_t k = 0; k < n; ++k) taken += b[k] * products[k];
        const double left = std::max(m_residual.Squares() - taken, 0.0);
        const double spread = left / double(std::max<size_t>(m_residual.Count(), n + 1) - n);
        std::string several;
        size_t count = 0;
        for (size_t k = 0; k < n; ++k) {
            const double error = std::sqrt(std::max(inverse[k * n + k] * std::max(spread, 1.0), 0.0));
            m_diagnosis.parts.push_back(
                {kind, parts[k].name, whole > 0.0 ? energy[k] / whole : 0.0, b[k], error});
            if (std::abs(b[k]) < 0.1 || std::abs(b[k]) < 5.0 * error) continue;
            several += Text("{}{} ({:+.0f} %)", count == 0 ? "" : ", ", PartText(parts[k]), 100.0 * b[k]);
            ++count;
        }
        if (count > 1)
            Add({kind, "", "several parts of the light are off: " + several, ExplainedBy(taken)},
                kCostOfNumber * double(n));
    }

    // Gains of the light of objects, whole and by part, and where the difference is.
    void WeighObjects(const std::string& kind, const std::vector<uint32_t>& ids,
                      const std::vector<std::string>& names) {
        if (ids.empty()) return;
        struct Of {
            size_t pixels = 0;
            double squares = 0.0, reference = 0.0, picture = 0.0;
            std::vector<Products> parts;
        };
        std::vector<LightPart> parts{{"whole", "", &m_residual.Reference()}};
        for (const LightPart& part : PartsOf(m_render))
            if (part.kind != "light group") parts.push_back(part);
        std::map<uint32_t, Of> objects;
        size_t pixels = 0;
        for (size_t pixel = 0; pixel < ids.size(); ++pixel) {
            const size_t first = 4 * pixel;
            if (!(m_residual.Weight(first) > 0.0f)) continue;
            ++pixels;
            Of& of = objects[ids[pixel]];
            if (of.parts.empty()) of.parts.resize(parts.size());
            ++of.pixels;
            of.reference += LuminanceOf(&m_residual.Reference()[first]);
            of.picture += LuminanceOf(&m_residual.PictureRadiance()[first]);
            for (size_t i = first; i < first + 3; ++i) {
                const double weight = m_residual.Weight(i), e = m_residual.Difference(i);
                of.squares += weight * e * e - m_residual.NoiseAt(i);
                for (size_t k = 0; k < parts.size(); ++k)
                    of.parts[k].Add(i - first, weight, (*parts[k].radiance)[i], e);
            }
        }
        for (const auto& [id, of] : objects) {
            const bool isNothing = id >= names.size();
            // A material of one object alone, and the background, are told of as objects
            const bool isTold =
                std::ranges::any_of(m_diagnosis.objects, [&, &found = of](const ObjectShare& object) {
                    return object.kind != kind && object.pixels == found.pixels &&
                           object.squares == found.squares;
                });
            if (isTold) continue;
            const std::string name = isNothing ? "background" : names[id];
            const std::string called = isNothing ? "the background" : Text("{} `{}`", kind, Printable(name));
            const double share = m_residual.Signal() > 0.0 ? of.squares / m_residual.Signal() : 0.0;
            const double area = double(of.pixels) / double(std::max<size_t>(pixels, 1));
            m_diagnosis.objects.push_back({kind, name, share, area,
                                           of.reference > 0.0 ? of.picture / of.reference - 1.0 : 0.0,
                                           of.pixels, of.squares});
            // All of the picture is no object
            if (area > 0.97) continue;
            for (size_t k = 0; k < parts.size(); ++k) {
                const double amount = of.parts[k].AmountOfAll();
                const double byOne = ExplainedBy(of.parts[k].TakenByOne()),
                             byColors = ExplainedBy(of.parts[k].TakenByColors());
                const std::string what = k == 0 ? "its light" : PartText(parts[k]);
                const bool hasColor = byColors > byOne + 0.1;
                std::string text = called + ": " + AmountText(what, amount);
                if (hasColor)
                    text = Text("{}: the color of {} is off: {}, {} and {} of R, G and B", called, what,
                                GainText(of.parts[k], 0), GainText(of.parts[k], 1), GainText(of.parts[k], 2));
                Add({kind, name, text, hasColor ? byColors : byOne, amount},
                    kCostOfNumber * (hasColor ? 4.0
                                     : k == 0 ? 1.0
                                              : 2.0));
            }
            // The odds that the difference is in it, against those of a pixel
            const double inside = std::clamp(share, 0.0, 1.0);
            if (inside * (1.0 - area) > 4.0 * (1.0 - inside) * area)
                Add({kind, name,
                     called + (isNothing
                                   ? " differs, but not by a constant factor"
                                   : " differs, but not by a constant factor: check its normals, roughness, "
                                     "textures and shape"),
                     inside, of.reference > 0.0 ? of.picture / of.reference - 1.0 : 0.0},
                    kCostOfPlace);
        }
    }
    static std::string GainText(const Products& products, size_t c) {
        const double gain = products.xx[c] > 0.0 ? 1.0 + products.xe[c] / products.xx[c] : 1.0;
        return Text("{:.2f} times", gain);
    }

    void WeighPrediction(const char* kind, const std::string& text, double amount, double cost,
                         const std::function<void(const float* reference, float* predicted)>& predict) {
        Texels prediction(m_residual.Reference().size(), 0.0f);
        for (size_t i = 0; i < prediction.size(); i += 4) predict(&m_residual.Reference()[i], &prediction[i]);
        Add({kind, "", text, m_residual.Explained(m_residual.LeftBy(prediction)), amount}, cost);
    }

    // Mistakes of the whole picture.
    void WeighPicture() {
        const Products whole = ProductsOf(m_residual, m_residual.Reference());
        const double gain = 1.0 + whole.AmountOfAll();
        if (gain > 0.0)
            Add({"exposure", "",
                 Text("the whole picture is {:.2f} times as bright, {:+.2f} stops: its exposure is off", gain,
                      std::log2(gain)),
                 ExplainedBy(whole.TakenByOne()), std::log2(gain)},
                0.0);
        Add({"white balance", "",
             Text("the colors of the whole picture are off: {}, {} and {} of R, G and B", GainText(whole, 0),
                  GainText(whole, 1), GainText(whole, 2)),
             ExplainedBy(whole.TakenByColors())},
            4.0 * kCostOfNumber);
        const Transfer srgb;
        const auto each = [&](auto curve) {
            return [this, curve](const float* reference, float* predicted) {
                for (int c = 0; c < 3; ++c) predicted[c] = curve(reference[c] * m_scale) / m_scale;
            };
        };
        WeighPrediction("gamma", "the picture is encoded in sRGB once more than stated: gamma twice", 1.0,
                        0.0, each([&](float x) { return srgb.Encode(x); }));
        WeighPrediction("gamma", "the picture is decoded from sRGB once more than stated", -1.0, 0.0,
                        each([&](float x) { return srgb.Decode(x); }));
        Hypothesis power;
        double best = -1.0;
        for (double exponent = 0.3; exponent < 3.0; exponent *= 1.08) {
            if (std::abs(exponent - 1.0) < 0.02) continue;
            const auto before = m_diagnosis.hypotheses.size();
            WeighPrediction("gamma", Text("radiance is raised to the power {:.2f}: gamma is off", exponent),
                            exponent, kCostOfNumber, each([&](float x) {
                                return std::pow(std::max(x, 0.0f), static_cast<float>(exponent));
                            }));
            if (m_diagnosis.hypotheses.back().explained > best) {
                power = m_diagnosis.hypotheses.back();
                best = power.explained;
            }
            m_diagnosis.hypotheses.resize(before);
        }
        m_diagnosis.hypotheses.push_back(power);
        WeighPrediction("black", "the picture is black", 0.0, 0.0, [](const float*, float*) {});
        WeighPrediction("channels", "red and blue are swapped", 0.0, 0.0,
                        [](const float* reference, float* to) {
                            for (int c = 0; c < 3; ++c) to[c] = reference[2 - c];
                        });
        const auto [width, height] = std::pair(m_residual.Size().width, m_residual.Size().height);
        const auto turned = [&](bool isMirrored) {
            return [this, isMirrored, width = width, height = height, at = size_t{0}](const float*,
                                                                                      float* to) mutable {
                const size_t x = at % width, y = at / width;
                const size_t from = isMirrored ? y * width + (width - 1 - x) : (height - 1 - y) * width + x;
                for (size_t c = 0; c < 3; ++c) to[c] = m_residual.Reference()[4 * from + c];
                ++at;
            };
        };
        WeighPrediction("orientation", "the picture is upside down", 0.0, 0.0, turned(false));
        WeighPrediction("orientation", "left and right are swapped", 0.0, 0.0, turned(true));
        // A constant that is added, as by fog or a black level
        Products constant;
        for (size_t i = 0; i < m_residual.Reference().size(); ++i)
            if (m_residual.Weight(i) > 0.0f)
                constant.Add(i % 4, m_residual.Weight(i), 1.0, m_residual.Difference(i));
        Add({"offset", "", Text("{:+.3g} is added to all of the picture", constant.AmountOfAll()),
             ExplainedBy(constant.TakenByOne()), constant.AmountOfAll()},
            kCostOfNumber);
    }

    // The picture as this program's tone curves show it: it is to be without one.
    void WeighToneCurves() {
        for (const TonemapOperator curve : Values<TonemapOperator>()) {
            if (curve == TonemapOperator::Linear || curve == TonemapOperator::Srgb) continue;
            WeighPrediction(
                "tone curve",
                Text("the picture has the tone curve {}: render it without one, here by --tonemap srgb",
                     Name(curve)),
                0.0, 0.0, [&](const float* reference, float* predicted) {
                    const glm::vec3 shown = shading::TonemapLinearLight(
                        m_scale * glm::vec3(reference[0], reference[1], reference[2]),
                        static_cast<uint32_t>(curve));
                    for (int c = 0; c < 3; ++c) predicted[c] = shown[c] / m_scale;
                });
        }
    }

    // The reference, moved by a part of a pixel: Catmull and Rom's cubic through its pixels.
    void WeighShift() {
        const auto [width, height] =
            std::pair(static_cast<int>(m_residual.Size().width), static_cast<int>(m_residual.Size().height));
        if (width < 8 || height < 8) return;
        const int stride = std::max(1, width * height / 65536);
        const auto leftBy = [&](double dx, double dy) {
            const auto weights = [](double t) {
                return std::array<double, 4>{((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0,
                                             ((-1.5 * t + 2.0) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
            };
            const int ix = static_cast<int>(std::floor(-dx)), iy = static_cast<int>(std::floor(-dy));
            const std::array<double, 4> wx = weights(-dx - ix), wy = weights(-dy - iy);
            // Between pixels, the reference has less noise
            double squaresX = 0.0, squaresY = 0.0;
            for (size_t i = 0; i < 4; ++i) {
                squaresX += wx[i] * wx[i];
                squaresY += wy[i] * wy[i];
            }
            const double lost = 1.0 - squaresX * squaresY;
            double moved = 0.0, still = 0.0;
            for (int pixel = 0; pixel < width * height; pixel += stride) {
                const int x = pixel % width, y = pixel / width;
                if (x < 4 || y < 4 || x >= width - 4 || y >= height - 4) continue;
                for (int c = 0; c < 3; ++c) {
                    const size_t i = 4 * size_t(pixel) + size_t(c);
                    const double weight = m_residual.Weight(i);
                    if (!(weight > 0.0)) continue;
                    double value = 0.0;
                    for (int v = 0; v < 4; ++v)
                        for (int u = 0; u < 4; ++u) {
                            const int from = std::clamp(y + iy + v - 1, 0, height - 1) * width +
                                             std::clamp(x + ix + u - 1, 0, width - 1);
                            value += wy[size_t(v)] * wx[size_t(u)] *
                                     m_residual.Reference()[4 * size_t(from) + size_t(c)];
                        }
                    const double e = m_residual.PictureRadiance()[i] - value,
                                 before = m_residual.Difference(i);
                    moved += weight * e * e + lost * m_residual.ReferenceNoiseAt(i);
                    still += weight * before * before;
                }
            }
            return still > 0.0 ? moved / still : 1.0;
        };
        double x = 0.0, y = 0.0, best = 1.0;
        for (const double step : {1.0, 0.5, 0.25}) {
            const double cx = x, cy = y;
            const int reach = step == 1.0 ? 3 : 1;
            for (int v = -reach; v <= reach; ++v)
                for (int u = -reach; u <= reach; ++u) {
                    const double left = leftBy(cx + step * u, cy + step * v);
                    if (left < best) {
                        best = left;
                        x = cx + step * u;
                        y = cy + step * v;
                    }
                }
        }
        if (x == 0.0 && y == 0.0) return;
        Add({"shift", "",
             Text("the picture is shifted by {:+.2f} pixels to the right and {:+.2f} down: its camera, or "
                  "where "
                  "its pixels are sampled, is off",
                  x, y),
             m_residual.Explained(best * m_residual.Squares()), std::hypot(x, y)},
            kCostOfNumber);
    }

    const Residual& m_residual;
    const RenderFile& m_render;
    const SceneNames& m_names;
    float m_scale;
    Diagnosis m_diagnosis;
};

}  // namespace

Residual::Residual(const Picture& reference, const Picture& picture, const Texels& noise, double tolerance,
                   const std::vector<float>& relative)
    : m_size(picture.size), m_noise(noise) {
    const float white = std::min(reference.white, picture.white);
    m_reference = CutAt(reference.radiance, white);
    m_picture = CutAt(picture.radiance, white);
    m_referenceNoise = reference.variance;
    m_weights.assign(m_picture.size(), 0.0f);
    const size_t pixels = m_picture.size() / 4;
    double luminance = 0.0;
    for (size_t pixel = 0; pixel < pixels; ++pixel) luminance += LuminanceOf(&m_reference[4 * pixel]);
    const double floor = 0.05 * luminance / double(std::max<size_t>(pixels, 1));
    // A tolerance of 0 would leave nothing but the noise to weigh by, which may be 0
    const double least = std::max(tolerance, 0.01);
    for (size_t pixel = 0; pixel < pixels; ++pixel) {
        const double allowed = relative.empty() ? least : std::max(double{relative[pixel]}, 0.01);
        if (!std::isfinite(allowed)) continue;
        for (size_t i = 4 * pixel; i < 4 * pixel + 3; ++i) {
            if (m_picture[i] >= white || m_reference[i] >= white) continue;
            // The larger of both pictures, so that no pixel that is much too bright outweighs all others
            const double scale = std::max({double{m_reference[i]}, double{m_picture[i]}, floor,
                                           0.25 * LuminanceOf(&m_reference[4 * pixel]),
                                           0.25 * LuminanceOf(&m_picture[4 * pixel])});
            const double spread = m_noise[i] + allowed * allowed * scale * scale;
            if (!(spread > 0.0)) continue;
            m_weights[i] = static_cast<float>(1.0 / spread);
            const double e = double{m_picture[i]} - m_reference[i];
            m_squares += m_weights[i] * e * e;
            ++m_count;
        }
    }
    m_noiseScale = NoiseScale();
    m_signal = m_squares;
    for (size_t i = 0; i < m_weights.size(); ++i) m_signal -= NoiseAt(i);
    // Some of the difference is never noise, or there would be nothing to explain
    m_signal = std::max(m_signal, 0.1 * m_squares);
}

double Residual::NoiseScale() const {
    double stated = 0.0, found = 0.0;
    const size_t row = 4 * size_t{m_size.width};
    for (uint32_t y = 0; y + 1 < m_size.height; ++y)
        for (uint32_t x = 0; x + 1 < m_size.width; ++x)
            for (size_t c = 0; c < 3; ++c) {
                const size_t i = y * row + 4 * x + c;
                const std::array<size_t, 4> four{i, i + 4, i + row, i + row + 4};
                double weight = 0.0, noise = 0.0;
                for (const size_t k : four) {
                    weight = m_weights[k] > 0.0f ? weight + 0.25 * m_weights[k] : -1e30;
                    noise += 0.25 * m_noise[k];
                }
                if (!(weight > 0.0)) continue;
                const double d = 0.5 * (double{Difference(four[0])} - Difference(four[1]) -
                                        Difference(four[2]) + Difference(four[3]));
                found += weight * d * d;
                stated += weight * noise;
            }
    return stated > 0.0 ? std::min(found / stated, 1.0) : 1.0;
}

double Residual::Explained(double left) const {
    return m_signal > 0.0 ? std::clamp((m_squares - left) / m_signal, 0.0, 1.0) : 0.0;
}

double Residual::LeftBy(const Texels& prediction) const {
    double left = 0.0;
    for (size_t i = 0; i < prediction.size(); ++i) {
        if (!(m_weights[i] > 0.0f)) continue;
        const double e = double{m_picture[i]} - prediction[i];
        left += m_weights[i] * e * e;
    }
    return left;
}

std::vector<LightPart> PartsOf(const RenderFile& render) {
    std::vector<LightPart> parts;
    for (const passes::PathPart part : Values<passes::PathPart>()) {
        const Texels& radiance = render.parts[static_cast<size_t>(part)];
        if (radiance.empty()) continue;
        const bool isLobe = part >= passes::PathPart::Diffuse;
        parts.push_back({isLobe ? "lobe" : "path", Name(part), &radiance});
    }
    if (render.lightGroups.empty()) return parts;
    const std::vector<std::string> names = LightGroupNames(SettingsFrom(render.settings).lightGroups);
    for (size_t i = 0; i < render.lightGroups.size(); ++i)
        parts.push_back({"light group", names.at(i), &render.lightGroups[i]});
    return parts;
}

Diagnosis Diagnose(const Residual& residual, const RenderFile& render, const SceneNames& names,
                   float exposureEv) {
    return Diagnosing(residual, render, names, exposureEv).Run();
}

void Weigh(Diagnosis& diagnosis, const Residual& residual, const std::vector<Alternative>& alternatives,
           bool isScaled) {
    for (const Alternative& alternative : alternatives) {
        Hypothesis hypothesis{alternative.kind, alternative.name, alternative.text, 0.0, alternative.amount};
        if (isScaled) {
            Texels change = alternative.radiance;
            for (size_t i = 0; i < change.size(); ++i) change[i] -= residual.Reference()[i];
            const Products products = ProductsOf(residual, change);
            hypothesis.amount = products.AmountOfAll();
            if (hypothesis.amount <= 0.0) continue;
            hypothesis.explained = residual.Explained(residual.Squares() - products.TakenByOne());
        } else {
            hypothesis.explained = residual.Explained(residual.LeftBy(alternative.radiance));
        }
        hypothesis.score = hypothesis.explained - kCostOfNumber;
        diagnosis.hypotheses.push_back(std::move(hypothesis));
    }
}

void Rank(Diagnosis& diagnosis) {
    std::vector<Hypothesis>& all = diagnosis.hypotheses;
    std::erase_if(all, [](const Hypothesis& hypothesis) { return hypothesis.explained < kLeastExplained; });
    std::ranges::stable_sort(all, std::greater{}, &Hypothesis::score);
    // The best hypothesis about an object or a part says it all
    std::vector<Hypothesis> best;
    for (Hypothesis& hypothesis : all) {
        const bool isKnown = std::ranges::any_of(best, [&](const Hypothesis& other) {
            return other.kind == hypothesis.kind && other.name == hypothesis.name;
        });
        if (!isKnown && best.size() < kMostHypotheses) best.push_back(std::move(hypothesis));
    }
    all = std::move(best);
}

}  // namespace raygraph::session
