// Twin of shaft.rs, for shafts that start at one point.

// 2^-17.
const SHAFT_MARGIN = 7.6293945e-6;

struct Shaft {
    start: vec3f,
    low_inverse: vec3f,
    high_inverse: vec3f,
}

// Returns the shaft of all segments from `start` whose vectors end in the box from `low` to `high`.
fn shaft_to(start: vec3f, low: vec3f, high: vec3f) -> Shaft {
    let size = max(abs(low), abs(high));
    let margin = product(max(max(size.x, size.y), size.z), SHAFT_MARGIN);
    return Shaft(start, slab_inverse(low - margin), slab_inverse(high + margin));
}

fn shaft_enters(s: Shaft, low: vec3f, high: vec3f) -> bool {
    let at_high = (high - s.start) * s.low_inverse;
    let at_low = (low - s.start) * s.high_inverse;
    let low_rises = s.low_inverse >= vec3f(0.0);
    let high_rises = s.high_inverse >= vec3f(0.0);
    let until = min(select(vec3f(1.0), at_high, low_rises), select(at_low, vec3f(1.0), high_rises));
    let since = max(select(at_high, vec3f(0.0), low_rises), select(vec3f(0.0), at_low, high_rises));
    let entry = max(max(since.x, since.y), max(since.z, 0.0));
    let exit = min(min(until.x, until.y), min(until.z, 1.0));
    return entry <= exit * EXIT_SLACK;
}

fn shaft_enters_word(o: vec3f, low: vec3f, high: vec3f, box_low: vec3f, box_high: vec3f) -> u32 {
    return u32(shaft_enters(shaft_to(o, low, high), box_low, box_high));
}
