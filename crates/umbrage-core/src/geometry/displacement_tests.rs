use super::*;

/// Heights 0, 0.1, .. row by row.
fn texture(width: u32, height: u32) -> Texture {
    let texels = (0..width * height)
        .map(|i| [0.1 * i as f32, 9.0, 9.0, 9.0])
        .collect();
    Texture {
        name: "ramp".to_owned(),
        size: UVec2::new(width, height),
        texels,
    }
}

/// The textbook formula in f64: a sum over all texels of all nearby repeats, weighted by tents.
fn tents(t: &Texture, uv: Vec2) -> f64 {
    let w = t.size.x as i64;
    let h = t.size.y as i64;
    let at = [f64::from(uv.x) * w as f64, f64::from(uv.y) * h as f64];
    let tent = |centre: i64, x: f64| (1.0 - (centre as f64 + 0.5 - x).abs()).max(0.0);
    let texel = |x: i64, y: i64| {
        f64::from(
            t.texels
                .get((y.rem_euclid(h) * w + x.rem_euclid(w)) as usize)[0],
        )
    };
    let rows = -5 * h..5 * h;
    rows.flat_map(|y| (-5 * w..5 * w).map(move |x| (x, y)))
        .map(|(x, y)| texel(x, y) * tent(x, at[0]) * tent(y, at[1]))
        .sum()
}

#[test]
fn heights_are_bilinear_with_centres_at_halves_and_rows_from_the_top() {
    let t = texture(2, 3);
    assert_eq!(height(&t, Vec2::new(0.25, 0.5 / 3.0)), 0.0);
    assert_eq!(height(&t, Vec2::new(0.75, 2.5 / 3.0)), 0.5);
    // Halfway between the first two texels, and across the repeat.
    assert!((height(&t, Vec2::new(0.5, 0.5 / 3.0)) - 0.05).abs() < 1e-6);
    assert!((height(&t, Vec2::new(0.0, 0.5 / 3.0)) - 0.05).abs() < 1e-6);
    assert!(
        (height(&t, Vec2::new(0.25, 0.0)) - 0.2).abs() < 1e-6,
        "the mean of the first and the last row"
    );
}

#[test]
fn heights_agree_with_a_sum_of_tents() {
    let t = texture(4, 3);
    for i in -40..40 {
        let uv = Vec2::new(i as f32 * 0.0473, 0.3 - i as f32 * 0.0291);
        // Coordinates are below 2, texels below 8: a few roundings of 2^-22.
        assert!(
            (f64::from(height(&t, uv)) - tents(&t, uv)).abs() < 4e-6,
            "{uv}"
        );
    }
}

#[test]
fn every_coordinate_finds_texels() {
    for size in [UVec2::ONE, UVec2::new(1, 7), UVec2::new(5, 3)] {
        let t = texture(size.x, size.y);
        for u in [
            0.0,
            -0.0,
            -1e-9,
            1.0,
            -1.0,
            1.0 - f32::EPSILON / 2.0,
            1e30,
            -1e30,
            f32::MAX,
            16_777_217.0,
            1e-40,
        ] {
            for v in [u, 0.3, -u] {
                let h = height(&t, Vec2::new(u, v));
                assert!((0.0..=1.5).contains(&h), "{u} {v} in {size}: {h}");
            }
        }
    }
}

#[test]
fn heights_of_a_half_move_nothing() {
    let p = Vec3::new(1.0, 2.0, 3.0);
    let n = Vec3::Y;
    assert_eq!(displaced(p, n, 0.5, 7.0), p);
    assert_eq!(displaced(p, n, 1.0, 0.25), p + n * 0.25);
    assert_eq!(displaced(p, n, 0.0, 0.25), p - n * 0.25);
}
