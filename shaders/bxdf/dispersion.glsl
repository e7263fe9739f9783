// Dispersion (KHR_materials_dispersion): paths of one wavelength, where a medium refracts colors differently.
//
// A path carries three colors until it meets such a medium. There it draws a wavelength, once, and goes on
// with the share of each color that this wavelength has. The mean of these shares is 1, so that what follows
// stays unbiased for the colors of the scene, each of which stands for a band of wavelengths: a logistic
// curve with the mean and the standard deviation of the color matching function of linear sRGB (CIE 1931; its
// negative parts cut off, without the small violet part of red).
#ifndef RAYGRAPH_BXDF_DISPERSION_GLSL
#define RAYGRAPH_BXDF_DISPERSION_GLSL

#include "core/math.glsl"
#include "core/glue.h"

SHADING_BEGIN

// A path with this value carries all colors: media have their index at the d line for it.
CONST float kNoWavelength = 0.0f;

// In nm, of red, green and blue: mean, and scale of the logistic distribution, sqrt(3) / pi of its deviation.
CONST vec3 kBandMean = vec3(609.2f, 540.7f, 451.8f);
CONST vec3 kBandScale = vec3(14.16f, 15.45f, 11.71f);

// Returns the index of a medium that has `ior` at the d line, 587.6 nm, by Cauchy's formula. `dispersion` is
// 20 over the Abbe number, (n_d - 1) / (n_F - n_C); 523655 nm^2 is 1 / (1 / 486.1^2 - 1 / 656.3^2).
INLINE float DispersedIor(float ior, float dispersion, float wavelength) {
    if (wavelength == kNoWavelength) return ior;
    float power = 523655.0f / Sqr(wavelength) - 1.5168f;
    return max(ior + (ior - 1.0f) * dispersion * 0.05f * power, 1.0f);
}

// Returns the density of each color's band, 1/nm.
INLINE vec3 BandDensity(float wavelength) {
    vec3 density = vec3(0.0f);
    for (int band = 0; band < 3; ++band) {
        float tail = exp2(-1.44269504088896f * abs(wavelength - kBandMean[band]) / kBandScale[band]);
        density[band] = tail / (kBandScale[band] * Sqr(1.0f + tail));
    }
    return density;
}

// Returns a wavelength in nm, of any color with equal chance, by one number in [0, 1).
INLINE float SampleWavelength(float u) {
    int band = min(int(3.0f * u), 2);
    float share = clamp(3.0f * u - float(band), 1e-6f, 1.0f - 1e-6f);
    return kBandMean[band] + kBandScale[band] * 0.693147180559945f * log2(share / (1.0f - share));
}

// Returns the share of each color at a wavelength of SampleWavelength. Their sum is 3.
INLINE vec3 WavelengthShare(float wavelength) {
    vec3 density = BandDensity(wavelength);
    return density * (3.0f / (density.x + density.y + density.z));
}

SHADING_END

#endif
