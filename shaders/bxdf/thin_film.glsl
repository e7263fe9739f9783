// A thin film over the facets of a surface: light that is reflected at its two faces interferes, which gives
// colors that depend on the angle and on the film's thickness (KHR_materials_iridescence).
//
// L. Belcour and P. Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying
// Iridescence": Airy's formula is a series over the number of round trips within the film, and the spectrum
// of each term is a cosine of the optical path, whose mean over a channel's response is known in closed
// form if the response is a sum of Gaussians over the wave number. Here
// - Fresnel's equations are exact, for each polarization, and the base may absorb;
// - the responses are those of linear sRGB under daylight (D65), so that a gray film is gray: five
//   Gaussians, fitted to the CIE 1931 curves. The mean of any cosine is off by 0.02 at most; with the four
//   that the paper fits to XYZ, by 0.15;
// - four terms are summed and the rest extrapolated. The result is the change of the reflectance by the film.
// A film that is not there to light, because it has no thickness or the index of what is above it or below,
// changes nothing, by every Fresnel model.
//
// Linear sRGB does not hold all of these colors: the sum with the base must be clamped.
#ifndef RAYGRAPH_BXDF_THIN_FILM_GLSL
#define RAYGRAPH_BXDF_THIN_FILM_GLSL

#include "core/math.glsl"
#include "core/trace_options.glsl"

SHADING_BEGIN

struct ThinFilm {
    float weight;  // share of the facets that it is on
    float eta;     // index over that of the medium before the film
    float path;    // optical path through it and back along the normal, 2 index thickness; nm
};

INLINE ThinFilm NoFilm() {
    ThinFilm film;
    film.weight = 0.0f;
    film.eta = 1.0f;
    film.path = 0.0f;
    return film;
}

// Beyond this path there is no interference any more, and the sine of a float would lose its digits.
CONST float kMaxFilmPath = 1.0e5f;

// ----------------------------------------------------------------------------------------- complex numbers

// Holds a complex number for each channel.
struct ComplexColor {
    vec3 re;
    vec3 im;
};

INLINE ComplexColor ComplexOf(vec3 re, vec3 im) {
    ComplexColor z;
    z.re = re;
    z.im = im;
    return z;
}

INLINE ComplexColor Plus(ComplexColor a, ComplexColor b) { return ComplexOf(a.re + b.re, a.im + b.im); }
INLINE ComplexColor Scaled(ComplexColor a, vec3 scale) { return ComplexOf(a.re * scale, a.im * scale); }
INLINE vec3 AbsSquare(ComplexColor a) { return a.re * a.re + a.im * a.im; }

INLINE ComplexColor Times(ComplexColor a, ComplexColor b) {
    return ComplexOf(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re);
}

// 0 / 0 is 0.
INLINE ComplexColor Over(ComplexColor a, ComplexColor b) {
    vec3 scale = vec3(1.0f) / max(AbsSquare(b), vec3(1e-30f));
    return ComplexOf((a.re * b.re + a.im * b.im) * scale, (a.im * b.re - a.re * b.im) * scale);
}

// Returns the root in the upper right quarter, of numbers in the upper half.
INLINE ComplexColor UpperRoot(ComplexColor a) {
    vec3 size = sqrt(AbsSquare(a));
    return ComplexOf(sqrt(max(0.5f * (size + a.re), vec3(0.0f))),
                     sqrt(max(0.5f * (size - a.re), vec3(0.0f))));
}

// Returns (a - b) / (a + b), of which Fresnel's equations are made.
INLINE ComplexColor Contrast(ComplexColor a, ComplexColor b) {
    return Over(ComplexOf(a.re - b.re, a.im - b.im), ComplexOf(a.re + b.re, a.im + b.im));
}

// ----------------------------------------------------------------------------------- means over the spectrum

// Holds the mean of exp(2 pi i m path / wavelength) over the response of each channel, for m = 1, 2, 3, 4.
struct PathSpectrum {
    ComplexColor once;
    ComplexColor twice;
    ComplexColor thrice;
    ComplexColor fourTimes;
};

// Adds a Gaussian of the responses: its share of each channel, mean and standard deviation of the wave number
// in 1 / nm.
INLINE void AddGaussian(INOUT(PathSpectrum) spectrum, float path, vec3 share, float mean, float deviation) {
    float phase = kTwoPi * mean * path;
    float spread = kTwoPi * deviation * path;
    float c = cos(phase);
    float s = sin(phase);
    float c2 = c * c - s * s;
    float s2 = 2.0f * c * s;
    // The m-th is exp(-m^2 spread^2 / 2)
    float g = exp2(-0.721347520444482f * spread * spread);
    float g4 = Sqr(g * g);
    float g8 = g4 * g4;
    spectrum.once = Plus(spectrum.once, ComplexOf(share * (g * c), share * (g * s)));
    spectrum.twice = Plus(spectrum.twice, ComplexOf(share * (g4 * c2), share * (g4 * s2)));
    float g9 = g8 * g;
    spectrum.thrice =
        Plus(spectrum.thrice, ComplexOf(share * (g9 * (c2 * c - s2 * s)), share * (g9 * (s2 * c + c2 * s))));
    float g16 = g8 * g8;
    spectrum.fourTimes = Plus(spectrum.fourTimes, ComplexOf(share * (g16 * (c2 * c2 - s2 * s2)),
                                                            share * (g16 * 2.0f * c2 * s2)));
}

INLINE PathSpectrum SpectrumOf(float path) {
    ComplexColor zero = ComplexOf(vec3(0.0f), vec3(0.0f));
    PathSpectrum spectrum;
    spectrum.once = zero;
    spectrum.twice = zero;
    spectrum.thrice = zero;
    spectrum.fourTimes = zero;
    AddGaussian(spectrum, path, vec3(0.780595f, -0.199411f, 0.014327f), 1.62964e-3f, 6.30188e-5f);
    AddGaussian(spectrum, path, vec3(1.024021f, 0.323858f, -0.073152f), 1.72018e-3f, 9.46941e-5f);
    AddGaussian(spectrum, path, vec3(-0.734896f, 0.887363f, -0.080881f), 1.86111e-3f, 9.17342e-5f);
    AddGaussian(spectrum, path, vec3(-0.415410f, 0.254803f, 0.075938f), 2.12512e-3f, 1.27074e-4f);
    AddGaussian(spectrum, path, vec3(0.345690f, -0.266613f, 1.063768f), 2.21007e-3f, 1.02608e-4f);
    return spectrum;
}

// Returns the mean wave number of each channel, 1 / nm.
INLINE vec3 MeanWaveNumbers() { return vec3(1.5471e-3f, 1.8359e-3f, 2.2594e-3f); }

// Returns the real part of the mean of q / (1 - q), where each round trip of that path multiplies by q: four
// terms, and a geometric series that goes on as the fourth followed the third.
INLINE vec3 MeanOfRoundTrips(ComplexColor q, PathSpectrum spectrum) {
    ComplexColor q2 = Times(q, q);
    vec3 sum = Times(q, spectrum.once).re + Times(q2, spectrum.twice).re;
    ComplexColor third = Times(Times(q2, q), spectrum.thrice);
    ComplexColor fourth = Times(Times(q2, q2), spectrum.fourTimes);
    ComplexColor ratio = Over(fourth, third);
    // The decay is no faster than that of a single wavelength: the third may be near 0.
    ratio = Scaled(ratio, min(sqrt(AbsSquare(q) / max(AbsSquare(ratio), vec3(1e-30f))), vec3(1.0f)));
    ComplexColor rest = Over(fourth, ComplexOf(vec3(1.0f) - ratio.re, -ratio.im));
    return sum + third.re + rest.re;
}

// ----------------------------------------------------------------------------------------------- reflectance

// Returns Airy's reflectance for one polarization: r12 and r23 are the amplitudes of the upper face and of
// the lower, the latter with what one round trip does to the light.
INLINE vec3 AiryReflectance(ComplexColor r12, ComplexColor r23) {
    ComplexColor product = Times(r12, r23);
    return AbsSquare(Plus(r12, r23)) /
           max(AbsSquare(ComplexOf(vec3(1.0f) + product.re, product.im)), vec3(1e-12f));
}

// Returns the gain for one polarization, of a film that light passes. With q = -r12 r23 exp(2 pi i path /
// wavelength) Airy's reflectance is 1 - K (1 + 2 Re(q / (1 - q))), K = (1 - |r12|^2) (1 - |r23|^2) / (1 -
// |q|^2), and without a path likewise.
INLINE vec3 InterferenceGain(ComplexColor r12, ComplexColor r23, PathSpectrum spectrum) {
    vec3 upper = AbsSquare(r12);
    vec3 lower = AbsSquare(r23);
    vec3 passed = max(vec3(1.0f) - upper, vec3(0.0f)) * max(vec3(1.0f) - lower, vec3(0.0f)) /
                  max(vec3(1.0f) - upper * lower, vec3(1e-6f));
    ComplexColor q = Scaled(Times(r12, r23), vec3(-1.0f));
    ComplexColor without = Over(q, ComplexOf(vec3(1.0f) - q.re, -q.im));
    return 2.0f * passed * (without.re - MeanOfRoundTrips(q, spectrum));
}

// Returns what the film adds to the reflectance of a facet of the index eta + i k, which is relative to the
// medium before it, like the film's: less than 0 where the film reduces it. cosI > 0 is in that medium.
INLINE vec3 FilmGain(ThinFilm film, float cosI, vec3 eta, vec3 k) {
    if (!HasTraceFeature(kTraceIridescence)) return vec3(0.0f);
    vec3 zero = vec3(0.0f);
    float c = min(cosI, 1.0f);
    float sin2 = 1.0f - c * c;
    float square = film.eta * film.eta;
    ComplexColor baseSquare = ComplexOf(eta * eta - k * k, 2.0f * eta * k);
    // These are index times cosine, on the three sides of the two faces. Beyond total reflection at the upper
    // face it is imaginary within the film
    ComplexColor before = ComplexOf(vec3(c), zero);
    ComplexColor within = UpperRoot(ComplexOf(vec3(square - sin2), zero));
    ComplexColor below = UpperRoot(ComplexOf(baseSquare.re - vec3(sin2), baseSquare.im));
    ComplexColor r12s = Contrast(before, within);
    ComplexColor r23s = Contrast(within, below);
    ComplexColor r12p = Contrast(Scaled(before, vec3(square)), within);
    ComplexColor r23p = Contrast(Times(baseSquare, within), Scaled(below, vec3(square)));
    float path = min(film.path, kMaxFilmPath) / film.eta;
    if (square > sin2) {
        PathSpectrum spectrum = SpectrumOf(path * within.re.x);
        return 0.5f * (InterferenceGain(r12s, r23s, spectrum) + InterferenceGain(r12p, r23p, spectrum));
    }
    // Light only tunnels through. Without waves, a channel's mean wave number stands for it.
    vec3 tunneled = exp2((-1.44269504088896f * kTwoPi * path * within.im.x) * MeanWaveNumbers());
    vec3 with = AiryReflectance(r12s, Scaled(r23s, tunneled)) + AiryReflectance(r12p, Scaled(r23p, tunneled));
    return 0.5f * (with - AiryReflectance(r12s, r23s) - AiryReflectance(r12p, r23p));
}

SHADING_END

#endif
