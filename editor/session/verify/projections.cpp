#include "editor/session/verify/projections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "editor/session/verify/compared.h"
#include "editor/session/verify/diagnosis.h"

namespace raygraph::session {

namespace {

constexpr double kLeastPixels = 32.0;

// Returns, at each pixel, the mean of `plane` over those of 5 x 5 pixels around it that count, without the
// pixel itself; 0 where there is none.
std::vector<double> MeansAround(const std::vector<double>& plane, const std::vector<double>& counts,
                                Extent2D size) {
    const int width = static_cast<int>(size.width), height = static_cast<int>(size.height);
    const auto sums = [&](const std::vector<double>& of) {
        std::vector<double> rows(of.size()), all(of.size());
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int i = std::max(x - 2, 0); i <= std::min(x + 2, width - 1); ++i)
                    rows[size_t(y * width + x)] += of[size_t(y * width + i)];
        for (int y = 0; y < height; ++y)
            for (int i = std::max(y - 2, 0); i <= std::min(y + 2, height - 1); ++i)
                for (int x = 0; x < width; ++x) all[size_t(y * width + x)] += rows[size_t(i * width + x)];
        return all;
    };
    std::vector<double> means = sums(plane);
    const std::vector<double> around = sums(counts);
    for (size_t i = 0; i < means.size(); ++i) {
        const double count = around[i] - counts[i];
        means[i] = count > 0.5 ? (means[i] - plane[i]) / count : 0.0;
    }
    return means;
}

using Planes = std::array<std::vector<double>, 3>;

// Sums over pixels along a prediction.
struct Sums {
    double s = 0.0;                        // w x d
    double size = 0.0, sizeSquares = 0.0;  // w |x| times what errors are relative to
    double xx = 0.0;                       // w x^2
    double lost = 0.0;                     // by how much s may be off since noise is cut at white
    // Variances of s by the noise of each.
    double ofPicture = 0.0, ofReference = 0.0;
    double ee = 0.0, exx = 0.0, xxxx = 0.0;  // products of the terms of s and xx
};

class Projecting {
  public:
    Projecting(const Compared& all, const RenderFile* render, const SceneNames& names)
        : m_all(all), m_render(render), m_names(names) {
        const size_t pixels = PixelCount(all.size);
        std::vector<double> counts(pixels);
        for (size_t pixel = 0; pixel < pixels; ++pixel) counts[pixel] = all.Counts(pixel) ? 1.0 : 0.0;
        for (size_t c = 0; c < 3; ++c) {
            std::vector<double> spread(pixels);
            for (size_t pixel = 0; pixel < pixels; ++pixel) {
                if (!all.Counts(pixel)) continue;
                const size_t i = 4 * pixel + c;
                const double allowed = std::max(double{all.relative[pixel]}, 0.01) * all.Scale(pixel, c);
                spread[pixel] = double{all.noise[i]} + all.referenceNoise[i] + allowed * allowed;
            }
            m_weights[c] = MeansAround(spread, counts, all.size);
            for (size_t pixel = 0; pixel < pixels; ++pixel) {
                double& weight = m_weights[c][pixel];
                weight = weight > 0.0 && all.Counts(pixel) ? 1.0 / weight : 0.0;
            }
        }
        m_everywhere.assign(pixels, 1.0);
    }

    std::vector<Projection> Run() {
        AddPart("exposure", "", m_all.reference, true);
        if (m_render != nullptr)
            for (const LightPart& part : PartsOf(*m_render))
                AddPart(part.kind, part.name, *part.radiance, part.kind != "light group");
        AddShift();
        return Significant();
    }

  private:
    void AddPart(const std::string& kind, const std::string& name, const Texels& radiance, bool isOfObjects) {
        Planes means;
        std::vector<double> plane(radiance.size() / 4);
        for (size_t c = 0; c < 3; ++c) {
            for (size_t pixel = 0; pixel < plane.size(); ++pixel) plane[pixel] = radiance[4 * pixel + c];
            means[c] = MeansAround(plane, m_everywhere, m_all.size);
        }
        Add(kind, name, "", SumOver(means, [](size_t) { return true; }));
        if (!isOfObjects || m_render == nullptr) return;
        for (const auto& [of, ids, names] :
             {std::tuple("object", &m_render->instance, &m_names.instances),
              std::tuple("material", &m_render->material, &m_names.materials)}) {
            std::map<uint32_t, Sums> sums;
            for (size_t pixel = 0; pixel < ids->size(); ++pixel)
                if ((*ids)[pixel] < names->size()) AddPixel(sums[(*ids)[pixel]], means, pixel);
            for (const auto& [id, sum] : sums) Add(of, (*names)[id], name, sum);
        }
    }

    void AddShift() {
        const auto [width, height] = std::pair(m_all.size.width, m_all.size.height);
        for (const bool isAlongX : {true, false}) {
            Planes slopes;
            for (size_t c = 0; c < 3; ++c) {
                slopes[c].resize(m_everywhere.size());
                for (uint32_t y = isAlongX ? 0 : 1; y + (isAlongX ? 0 : 1) < height; ++y)
                    for (uint32_t x = isAlongX ? 1 : 0; x + (isAlongX ? 1 : 0) < width; ++x) {
                        const size_t pixel = size_t{y} * width + x, step = isAlongX ? 1 : width;
                        slopes[c][pixel] = 0.5 * (double{m_all.reference[4 * (pixel - step) + c]} -
                                                  m_all.reference[4 * (pixel + step) + c]);
                    }
            }
            Add("shift", isAlongX ? "along x" : "along y", "", SumOver(slopes, [](size_t) { return true; }));
        }
    }

    template <typename IsIn>
    Sums SumOver(const Planes& prediction, const IsIn& isIn) const {
        Sums sums;
        for (size_t pixel = 0; pixel < m_everywhere.size(); ++pixel)
            if (isIn(pixel)) AddPixel(sums, prediction, pixel);
        return sums;
    }

    void AddPixel(Sums& sums, const Planes& prediction, size_t pixel) const {
        if (!m_all.Counts(pixel)) return;
        double e = 0.0, xx = 0.0, size = 0.0, ofPicture = 0.0, ofReference = 0.0;
        for (size_t c = 0; c < 3; ++c) {
            const size_t i = 4 * pixel + c;
            const double x = prediction[c][pixel], wx = m_weights[c][pixel] * x;
            e += wx * (double{m_all.picture[i]} - m_all.reference[i]);
            xx += wx * x;
            size += std::abs(wx) * m_all.Scale(pixel, c);
            sums.lost += std::abs(wx) * m_all.LostAtWhite(i);
            ofPicture += std::abs(wx) * std::sqrt(double{m_all.ownNoise[i]});
            ofReference += std::abs(wx) * std::sqrt(double{m_all.ownReferenceNoise[i]});
        }
        sums.s += e;
        sums.size += size;
        sums.sizeSquares += size * size;
        sums.xx += xx;
        sums.ofPicture += ofPicture * ofPicture;
        sums.ofReference += ofReference * ofReference;
        sums.ee += e * e;
        sums.exx += e * xx;
        sums.xxxx += xx * xx;
    }

    void Add(const std::string& kind, const std::string& name, const std::string& part, const Sums& sums) {
        if (!(sums.xx > 0.0) || sums.size * sums.size < kLeastPixels * sums.sizeSquares) return;
        const double amount = sums.s / sums.xx;
        const double left = sums.ee - 2.0 * amount * sums.exx + amount * amount * sums.xxxx;
        const double ofPicture = std::max(sums.ofPicture, m_all.noiseRatio * sums.ofReference);
        const double deviation = std::sqrt(std::max(ofPicture + sums.ofReference, left));
        m_deviations.push_back({deviation / sums.size, std::sqrt(ofPicture) / sums.size,
                                std::sqrt(sums.ofReference) / sums.size});
        m_found.push_back({.kind = kind,
                           .name = name,
                           .part = part,
                           .amount = amount,
                           .z = deviation > 0.0 ? sums.s / deviation : 0.0,
                           .error = std::max(std::abs(sums.s) - sums.lost, 0.0) / sums.size});
    }

    std::vector<Projection> Significant() {
        const double k = SidakDeviations(m_found.size(), 0.01);
        for (size_t i = 0; i < m_found.size(); ++i) {
            Projection& found = m_found[i];
            const Deviations& deviations = m_deviations[i];
            found.errorForRight = found.error - k * deviations.ofPicture + 2.0 * deviations.ofReference;
            found.errorForWrong =
                found.error - k * std::max(deviations.all, deviations.ofPicture + deviations.ofReference);
            found.error -= k * deviations.all;
        }
        std::erase_if(m_found, [](const Projection& found) {
            return found.error <= 0.0 && found.errorForRight <= 0.0;
        });
        std::ranges::stable_sort(m_found, std::greater{}, &Projection::error);
        return std::move(m_found);
    }

    const Compared& m_all;
    const RenderFile* m_render;
    const SceneNames& m_names;
    Planes m_weights;
    std::vector<double> m_everywhere;
    std::vector<Projection> m_found;
    // Relative standard deviations of the sums.
    struct Deviations {
        double all, ofPicture, ofReference;
    };
    std::vector<Deviations> m_deviations;
};

}  // namespace

std::vector<Projection> Project(const Compared& all, const RenderFile* render, const SceneNames& names) {
    return Projecting(all, render, names).Run();
}

SceneNames NamesOf(const scene::SceneData& scene) {
    SceneNames names;
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        std::string name = instance.node != scene::kNone ? scene.nodes[instance.node].name : std::string();
        if (name.empty()) name = scene.meshes[instance.mesh].name;
        names.instances.push_back(name.empty() ? std::to_string(i) : name);
    }
    for (size_t i = 0; i < scene.materials.size(); ++i)
        names.materials.push_back(scene.materials[i].name.empty() ? std::to_string(i)
                                                                  : scene.materials[i].name);
    return names;
}

std::string ToText(const Projection& projection) {
    if (projection.kind == "exposure") return "the whole picture";
    if (projection.kind == "shift") return "a shift " + projection.name;
    const std::string text = projection.kind + " `" + Printable(projection.name) + "`";
    return projection.part.empty() ? text : text + ", its " + projection.part + " light";
}

double SidakDeviations(size_t count, double significance) {
    const double ofOne = -std::expm1(std::log1p(-significance) / double(std::max<size_t>(count, 1)));
    double low = 0.0, high = 40.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::erfc(middle / std::numbers::sqrt2) > ofOne ? low : high) = middle;
    }
    return high;
}

}  // namespace raygraph::session
