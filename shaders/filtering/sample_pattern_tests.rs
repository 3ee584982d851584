use super::*;

const ALL: [Pattern; 3] = [Pattern::Vogel, Pattern::Poisson, Pattern::Grid];

/// Compares fractions of taps in regions of known area, for all patterns and both shapes. With 64
/// taps, a region's border may gain or lose about as many taps as cross it: an eighth of the
/// width's 8.
#[test]
fn taps_keep_areas() {
    for pattern in ALL {
        for (shape, inner) in [(PatternShape::Disc, 0.25), (PatternShape::Square, 0.25)] {
            let taps = spread(pattern, shape, 64);
            assert_eq!(taps.len(), 64);
            let share =
                |f: &dyn Fn(&Vec2) -> bool| taps.iter().filter(|q| f(q)).count() as f32 / 64.0;
            let norm = |q: &Vec2| {
                if shape == PatternShape::Disc {
                    q.length()
                } else {
                    q.abs().max_element()
                }
            };
            assert!(taps.iter().all(|q| norm(q) <= 1.0));
            for (share, area) in [
                (share(&|q| norm(q) < 0.5), inner),
                (share(&|q| q.x < 0.0), 0.5),
                (share(&|q| q.y < 0.0), 0.5),
            ] {
                assert!(
                    (share - area).abs() <= 0.125,
                    "{pattern:?} on {shape:?}: {share} of {area}"
                );
            }
        }
    }
}

/// 1,024 hexagonally packed taps could be at most 2 sqrt(pi / (2 sqrt(3) n)) apart. Random taps are
/// much closer than half of that.
#[test]
fn poisson_taps_keep_apart() {
    for (shape, area) in [
        (PatternShape::Disc, std::f32::consts::PI),
        (PatternShape::Square, 4.0),
    ] {
        let taps = spread(Pattern::Poisson, shape, 128);
        let nearest = (0..128)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| distance_squared(shape, taps[i], taps[j]).sqrt())
            .fold(f32::INFINITY, f32::min);
        let packed = (2.0 * area / (3.0_f32.sqrt() * 128.0)).sqrt();
        assert!(
            nearest > 0.5 * packed,
            "{shape:?}: {nearest}, packed {packed}"
        );
    }
}

/// Compares with Jimenez's own formula in `f64`, except at the borders of steps.
#[test]
fn noise_is_jimenezs() {
    let mut equal = 0;
    let mut all = 0;
    for y in 0..64 {
        for x in 0..64 {
            let inner = (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract();
            let noise = (52.982_918_9 * inner).fract();
            equal += u32::from(noise_index(x, y) == (noise * 64.0) as u32);
            all += 1;
        }
    }
    assert!(equal * 1000 > all * 995, "{equal} of {all}");
}

#[test]
fn bad_counts_are_refused_and_equal_tables_shared() {
    for count in [0, MAX_TAPS + 1] {
        let error = PatternTable::new(
            Pattern::Vogel,
            PatternShape::Disc,
            &[("pcss filter taps", count)],
        )
        .unwrap_err();
        assert!(
            error.to_string().starts_with("pcss filter taps: are"),
            "{error}"
        );
    }
    let make = |count| {
        PatternTable::new(
            Pattern::Grid,
            PatternShape::Square,
            &[("a", 3), ("b", count)],
        )
        .unwrap()
    };
    assert!(Arc::ptr_eq(make(5).table.rows(), make(5).table.rows()));
    assert!(!Arc::ptr_eq(make(5).table.rows(), make(6).table.rows()));
    assert_eq!(make(5).table.rows().len(), 8 + TURNS as usize);
}

/// Taps moved closer to the centre, with their weights, represent areas. The weights within a
/// distance add up to the distance's square. A border may gain or lose a ring of taps; 255 taps
/// form about 9 rings.
#[test]
fn taps_drawn_closer_keep_their_areas() {
    for shape in [PatternShape::Disc, PatternShape::Square] {
        let taps: Vec<(f32, f32)> = spread(Pattern::Vogel, shape, MAX_TAPS)
            .iter()
            .map(|q| {
                if shape == PatternShape::Disc {
                    q.length()
                } else {
                    q.abs().max_element()
                }
            })
            .map(|m| (m * closer_by(m), tap_weight(m, 2.0)))
            .collect();
        let all: f32 = taps.iter().map(|tap| tap.1).sum();
        for distance in [0.25_f32, 0.5, 0.75] {
            let within: f32 = taps
                .iter()
                .filter(|tap| tap.0 <= distance)
                .map(|tap| tap.1)
                .sum();
            assert!(
                (within / all - distance * distance).abs() < 0.03,
                "{shape:?} {distance}: {}",
                within / all
            );
        }
    }
    assert_eq!(tap_weight(0.5, 1.0), 4.0 * tap_weight(0.5, 2.0));
}
