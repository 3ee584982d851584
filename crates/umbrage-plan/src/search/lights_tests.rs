//! Tests of plans for all lights.

use super::*;
use crate::motion::FrameMotion;
use glam::UVec2;

/// Compares with all possible choices.
#[test]
fn picks_are_the_best_of_all() {
    let random = |i: u32| f64::from(umbrage_core::light_sample::hash(i)) / f64::from(u32::MAX);
    for seed in 0..50 {
        let lists: Vec<Vec<Item>> = (0..3)
            .map(|light| {
                (0..5)
                    .map(|i| {
                        let at = 100 * seed + 10 * light + 2 * i;
                        Item {
                            milliseconds: random(at),
                            square: random(at + 1),
                            bytes: 0,
                        }
                    })
                    .collect()
            })
            .collect();
        let budget = 0.5 + random(seed + 77);
        let mut least = f64::INFINITY;
        for [i, j, k] in (0..125).map(|n| [n / 25, n / 5 % 5, n % 5]) {
            let [a, b, c] = [lists[0][i], lists[1][j], lists[2][k]];
            if a.milliseconds + b.milliseconds + c.milliseconds <= budget {
                least = least.min(a.square + b.square + c.square);
            }
        }
        let picks = best_picks(&lists);
        let found = picks.iter().rev().find(|p| p.milliseconds <= budget);
        let found = found.map_or(f64::INFINITY, |p| p.squares);
        assert_eq!(found, least, "seed {seed}");
    }
}

/// Kept maps of all sizes take equal times: the error bound decides about their sizes.
#[test]
fn equal_times_go_to_fewer_bytes() {
    let item = |milliseconds, square, bytes| Item {
        milliseconds,
        square,
        bytes,
    };
    let list = vec![
        item(0.0, 1.0, 0),
        item(1.0, 0.02, 6),
        item(1.0, 0.01, 24),
        item(1.0, 0.001, 384),
        item(1.5, 0.001, 12),
    ];
    let lists = vec![list; 9];
    let bytes = |picks: &Picks| picks.sum_of(&lists, |item| item.bytes as f64);
    let within = |max_squares: f64| {
        let picks = best_picks(&lists);
        let found = picks.iter().find(|p| p.squares <= max_squares);
        let found = found.expect("within the bound").clone();
        let saved = with_fewer_bytes(
            found.clone(),
            &lists,
            1.001 * found.milliseconds,
            max_squares,
        );
        assert!(saved.milliseconds <= 1.001 * found.milliseconds);
        assert!(saved.squares <= max_squares, "{saved:?}");
        [bytes(&found), bytes(&saved)]
    };
    assert_eq!(within(0.091), [9.0 * 384.0, 9.0 * 24.0]);
    assert_eq!(within(0.181), [9.0 * 384.0, 9.0 * 6.0]);
    // Nothing smaller is within a bound that only the largest maps meet.
    assert_eq!(within(0.0091), [9.0 * 384.0, 9.0 * 384.0]);
    // One smaller map saves as many bytes as the bound permits.
    assert_eq!(within(0.0185), [9.0 * 384.0, 8.0 * 384.0 + 24.0]);
}

/// One light takes a more accurate setting that is small, so that another may take a smaller one.
#[test]
fn two_lights_exchange_error_for_bytes() {
    let item = |milliseconds, square, bytes| Item {
        milliseconds,
        square,
        bytes,
    };
    // The fastest choice of both lights has 392 bytes. No replacement of one light saves any
    // within the bounds.
    let lists = [
        vec![
            item(0.0, 9.0, 0),
            item(1.0, 0.010, 8),
            item(1.02, 0.0, 9),
            item(9.0, 0.0, 1),
        ],
        vec![
            item(0.0, 9.0, 0),
            item(1.0, 0.001, 384),
            item(1.0, 0.008, 96),
        ],
    ];
    let places = |max_milliseconds, max_squares| {
        let picks = best_picks(&lists);
        let fastest = picks.iter().find(|p| p.squares <= max_squares);
        let fastest = fastest.expect("within the bound").clone();
        assert_eq!(fastest.places, [1, 1]);
        with_fewer_bytes(fastest, &lists, max_milliseconds, max_squares).places
    };
    assert_eq!(places(2.1, 0.012), [2, 2]);
    // Not beyond the time.
    assert_eq!(places(2.01, 0.012), [1, 1]);
}

/// Lamps in a yard of pillars: their maps stay small, since slack of the bound is spent on bytes and
/// the fronts have small settings.
#[test]
fn nine_lamps_share_few_bytes() {
    let mut text = String::from(
        r#"
[camera]
eye = [9, 6, 11]
target = [0, 0, 0]
fov_y_degrees = 45
size = [320, 180]
[[object]]
shape = "plane"
scale = [8, 1, 8]
"#,
    );
    for i in 0..9 {
        let [x, z] = [i % 3, i / 3].map(|k| 4 * k - 4);
        text += &format!("[[light]]\nkind = \"point\"\nposition = [{x}, 2.5, {z}]\n");
    }
    for i in 0..16 {
        let [x, z] = [i % 4, i / 4].map(|k| 3.4 * f64::from(k) - 5.1);
        text += &format!(
            "[[object]]\nshape = \"box\"\nscale = [0.2, 1.2, 0.2]\ntranslate = [{x}, 1.2, {z}]\n"
        );
    }
    let scene = umbrage_scenes::parse(&text, "lamps.toml", ".").expect("valid");
    let options = PlanOptions {
        samples: 1024,
        ..PlanOptions::default()
    };
    let budget = LightsBudget::Error(0.03);
    let plan = plan_lights(&scene, budget, &Bounds::default(), &options, None, &|_| {})
        .expect("can be planned");
    assert!(plan.miss.is_none() && plan.high <= 0.03, "{plan:?}");
    let chosen = plan.lights.iter().flat_map(|light| &light.chosen);
    let bytes: u64 = chosen.map(|setting| setting.bytes).sum();
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    // It is 79. Without exchange between lights it was 2.8 times as much.
    assert!(mebibytes <= 120.0, "{mebibytes} MiB");
}

fn lights(budget: LightsBudget) -> LightsPlan {
    let scene = umbrage_scenes::by_argument("cubes").expect("built in");
    // The same light twice, and one that lights nothing.
    let astray = umbrage_core::Light::Spot {
        position: 50.0 * glam::Vec3::Y,
        direction: glam::Vec3::Y,
        inner: 0.1,
        outer: 0.2,
        radius: 0.0,
    };
    let scene = Scene {
        lights: vec![scene.lights[0], scene.lights[0], astray],
        ..scene
    };
    let options = PlanOptions {
        samples: 1024,
        size: Some(UVec2::new(160, 120)),
        motion: FrameMotion::AllMoves,
        ..PlanOptions::default()
    };
    plan_lights(&scene, budget, &Bounds::default(), &options, None, &|_| {})
        .expect("can be planned")
}

#[test]
fn equal_lights_share_a_budget_and_an_unseen_one_takes_none_of_it() {
    let plan = lights(LightsBudget::Error(0.05));
    assert!(plan.miss.is_none() && plan.high <= 0.05, "{plan:?}");
    let names: Vec<&str> = plan
        .lights
        .iter()
        .map(|light| &*light.chosen.as_ref().expect("chosen").technique)
        .collect();
    assert_ne!(names[0], "none");
    assert_eq!(names[2], "none", "its shadow is not visible");
    // The same time buys no greater error.
    let again = lights(LightsBudget::Milliseconds(plan.milliseconds));
    assert!(again.high <= plan.high && again.milliseconds <= plan.milliseconds);
    // Choose a budget halfway between that and the least time.
    let quickest = |light: &LightPlan| {
        let times = light.front.iter().map(|setting| setting.milliseconds);
        times.fold(f64::INFINITY, f64::min)
    };
    let least: f64 = plan.lights.iter().map(quickest).sum();
    assert!(least < plan.milliseconds);
    let halfway = 0.5 * (least + plan.milliseconds);
    let little = lights(LightsBudget::Milliseconds(halfway));
    assert!(little.miss.is_none() && little.error > plan.error);
}

#[test]
fn what_cannot_be_is_reported() {
    let time = lights(LightsBudget::Milliseconds(0.0));
    assert!(
        time.miss
            .is_some_and(|miss| miss.contains("even without any shadow"))
    );
    assert!(LightsBudget::Milliseconds(-1.0).validate().is_err());
    assert!(LightsBudget::Error(2.0).validate().is_err());
}
