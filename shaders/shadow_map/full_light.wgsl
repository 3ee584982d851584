// What no map covers is lit. Techniques that know better have a `full_light` of their own.

fn full_light(r: Receiver) -> f32 {
    return 1.0;
}
