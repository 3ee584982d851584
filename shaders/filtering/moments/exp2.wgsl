// Twin of exp2.rs: power of two, in a fixed order of operations.

fn power_of_two(exponent: f32) -> f32 {
    let t = min(max(exponent, -126.0), 126.0);
    let whole = floor(t + 0.5);
    let rest = t - whole;
    var sum = 1.5353362e-4;
    sum = sum * rest + 1.3398875e-3;
    sum = sum * rest + 9.618437e-3;
    sum = sum * rest + 5.5503324e-2;
    sum = sum * rest + 2.4022648e-1;
    sum = sum * rest + 6.931472e-1;
    sum = sum * rest + 1.0;
    return bitcast<f32>(bitcast<i32>(sum) + (i32(whole) << 23u));
}
