// Diagnosis says what explains the difference of a picture and the reference: a part of the light, an object,
// a material, or a mistake of the whole picture. Each is a hypothesis that predicts a picture from the
// reference and its AOVs; what its prediction leaves of the difference tells how well it explains it.
// Threads: pure functions.
#pragma once

#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/file/render_file.h"
#include "editor/session/verify/picture.h"
#include "editor/session/verify/verdict.h"

namespace raygraph::session {

struct Hypothesis {
    std::string kind;  // "light group", "path", "lobe", "material", "object", "exposure", "shift" ...
    std::string name;  // of the part, material or object; "": none
    std::string text;  // a sentence without its full stop
    double explained =
        0.0;              // share of the squared difference, noise excluded, that its prediction takes away
    double amount = 0.0;  // of a part: picture = reference + amount * part; else a number of its own
    double score = 0.0;   // ranks hypotheses: explained, minus a penalty for each fitted number
};

// A part of the light, and how much more of it the picture has than the reference: fitted together with the
// other parts of the same kind, which sum to the whole radiance.
struct PartFit {
    std::string kind, name;  // as in Hypothesis
    double share = 0.0;      // of the energy of the reference
    double amount = 0.0, standardError = 0.0;
};

// The share of the difference that falls on an object or a material.
struct ObjectShare {
    std::string kind, name;
    double share = 0.0;          // of the squared difference, noise excluded
    double area = 0.0;           // share of the pixels
    double relativeError = 0.0;  // of its mean luminance
    size_t pixels = 0;           // that count
    double squares = 0.0;        // weighted, noise excluded
};

struct Diagnosis {
    std::vector<Hypothesis> hypotheses;  // best first, at most 8
    std::vector<PartFit> parts;
    std::vector<ObjectShare> objects;  // most of the difference first, at most 16
};

// A part of the light as a picture: {"light group", "lamp", texels}.
struct LightPart {
    std::string kind, name;
    const Texels* radiance;
};

// A picture that the scene would give if something were otherwise, as the host's mistake may be.
struct Alternative {
    std::string kind, name, text;
    Texels radiance;
    double amount = 0.0;
};

// The difference of two pictures, weighted: a value of an error as large as the tolerance or the noise counts
// 1.
class RAYGRAPH_API Residual {
  public:
    // `relative` is that of JudgedAgainst, empty for one for all; `noise` the variance of picture -
    // reference.
    Residual(const Picture& reference, const Picture& picture, const Texels& noise, double tolerance,
             const std::vector<float>& relative = {});

    Extent2D Size() const { return m_size; }
    // Returns the weight of a value of a texel, 0 where it does not count.
    float Weight(size_t i) const { return m_weights[i]; }
    float Difference(size_t i) const { return m_picture[i] - m_reference[i]; }
    const Texels& Reference() const { return m_reference; }
    const Texels& PictureRadiance() const { return m_picture; }
    // Return what noise is expected to add to the squares: all of it, and that of the reference.
    double NoiseAt(size_t i) const { return m_noiseScale * m_weights[i] * m_noise[i]; }
    double ReferenceNoiseAt(size_t i) const {
        return m_referenceNoise.empty() ? 0.0 : m_noiseScale * m_weights[i] * m_referenceNoise[i];
    }
    double Squares() const { return m_squares; }  // of all weighted differences
    double Signal() const { return m_signal; }    // the same, noise excluded
    size_t Count() const { return m_count; }      // of values that count
    // Returns the share of the signal that is gone when `left` is left of the squares.
    double Explained(double left) const;
    // Returns what a prediction of the picture leaves.
    double LeftBy(const Texels& prediction) const;

  private:
    Extent2D m_size;
    Texels m_reference, m_picture, m_weights, m_noise, m_referenceNoise;
    // Estimates the noise that there is, as a share of the stated one, which is that of independent samples:
    // from differences of neighbors along both axes, which keep all of the noise and little of a mistake.
    double NoiseScale() const;

    double m_squares = 0.0, m_signal = 0.0, m_noiseScale = 1.0;
    size_t m_count = 0;
};

// Returns all parts of a render's light that it has.
RAYGRAPH_API std::vector<LightPart> PartsOf(const RenderFile& render);

// `render` has the AOVs that there are of the reference; light groups are called as `names` says.
RAYGRAPH_API Diagnosis Diagnose(const Residual& residual, const RenderFile& render, const SceneNames& names,
                                float exposureEv);

// Adds hypotheses that were rendered: picture = reference + c (alternative - reference), with c fitted, for
// those with `isScaled`, or the alternative itself. All pictures have the size of the residual.
RAYGRAPH_API void Weigh(Diagnosis& diagnosis, const Residual& residual,
                        const std::vector<Alternative>& alternatives, bool isScaled);

// Sorts the hypotheses, best first, and drops those that explain little.
RAYGRAPH_API void Rank(Diagnosis& diagnosis);

}  // namespace raygraph::session
