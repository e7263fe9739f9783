#version 460
// A step of the Gray-Scott model of two substances that diffuse and react: x is fed, y uses it up and is taken
// away. The first frame begins with drops of y. The picture has no edges: its sides meet.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rg32f) uniform readonly image2D before;
layout(binding = 1, rg32f) uniform writeonly image2D after;
layout(push_constant) uniform Push {
    int frame;
    float feed;
    float kill;
};

ivec2 size = imageSize(after);

vec2 Drops(ivec2 texel) {
    float y = 0.0;
    for (int i = 0; i < 24; ++i) {
        vec2 center = fract(vec2(0.7548776662, 0.5698402910) * float(i + 1)) * vec2(size);
        if (distance(vec2(texel), center) < 4.0) y = 1.0;
    }
    return vec2(1.0 - 0.5 * y, 0.5 * y);
}

vec2 At(ivec2 texel) {
    texel = (texel + size) % size;
    return frame == 0 ? Drops(texel) : imageLoad(before, texel).xy;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 here = At(texel), around = -here;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (x != 0 || y != 0) around += (x == 0 || y == 0 ? 0.2 : 0.05) * At(texel + ivec2(x, y));
    float reaction = here.x * here.y * here.y;
    vec2 change = vec2(1.0, 0.5) * around + vec2(feed * (1.0 - here.x) - reaction, reaction - (feed + kill) * here.y);
    imageStore(after, texel, vec4(here + change, 0.0, 0.0));
}
