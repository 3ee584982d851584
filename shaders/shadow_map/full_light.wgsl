// Default for receivers outside the map: lit. Some techniques define another `full_light`.

fn full_light(r: Receiver) -> f32 {
    return 1.0;
}
