//! Inputs for twins: many kinds of numbers, the same ones in every run.

use super::wrapper::{count, scalar};
use proptest::{
    prelude::*,
    sample::select,
    strategy::ValueTree as _,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use std::{
    collections::HashMap,
    sync::{Arc, LazyLock, Mutex, PoisonError},
};
use umbrage_core::Twin;

/// Number of inputs for each pair, a multiple of the wrapper's workgroup size.
pub const COUNT: usize = 65_536;

/// Cache of inputs, by the types of their parameters.
type Drawn = HashMap<Vec<&'static str>, Arc<[u32]>>;

/// Returns the words of [`COUNT`] inputs, one after the other. Twins with the same parameters
/// receive the same inputs in every run. They are drawn once, which takes a second.
pub fn draw(twin: &Twin) -> Arc<[u32]> {
    static DRAWN: LazyLock<Mutex<Drawn>> = LazyLock::new(Mutex::default);
    // A test that failed while it held the lock reports that itself.
    let mut drawn = DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
    drawn
        .entry(twin.parameters.to_vec())
        .or_insert_with(|| draw_fresh(twin))
        .clone()
}

fn draw_fresh(twin: &Twin) -> Arc<[u32]> {
    let scalars: Vec<_> = twin
        .parameters
        .iter()
        .flat_map(|t| std::iter::repeat_n(scalar(t), count(t)))
        .collect();
    let strategies = [Mood::Cube, Mood::Grid, Mood::Scales, Mood::Any].map(|mood| {
        scalars
            .iter()
            .map(|s| component(s, mood))
            .collect::<Vec<_>>()
    });
    let mut runner = TestRunner::new_with_rng(
        Config::default(),
        TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]),
    );
    (0..COUNT)
        .flat_map(|i| {
            let tree = strategies[i % strategies.len()].new_tree(&mut runner);
            tree.expect("no strategy rejects").current()
        })
        .collect()
}

/// Relation between the numbers of one input. Independent random numbers seldom interact: a ray
/// among them hits nothing.
#[derive(Clone, Copy)]
enum Mood {
    /// Positions in a unit cube.
    Cube,
    /// Few values: many ties, zeros and degenerate shapes.
    Grid,
    /// Magnitudes from 1e-6 to 1e6.
    Scales,
    /// A separate kind for each number, including zeros of both signs and extremes.
    Any,
}

fn component(scalar: &str, mood: Mood) -> BoxedStrategy<u32> {
    match scalar {
        "u32" => unsigned(mood),
        "i32" => signed_bits(mood),
        _ => float(mood).prop_map(f32::to_bits).boxed(),
    }
}

fn float(mood: Mood) -> BoxedStrategy<f32> {
    match mood {
        Mood::Cube => (-1.0_f32..1.0).boxed(),
        Mood::Grid => (-2..=2_i32).prop_map(|i| i as f32 / 2.0).boxed(),
        Mood::Scales => (any::<bool>(), -20.0_f32..20.0)
            .prop_map(|(negative, e)| if negative { -e.exp2() } else { e.exp2() })
            .boxed(),
        Mood::Any => {
            let special = select(&SPECIAL[..]);
            prop_oneof![
                float(Mood::Cube),
                float(Mood::Grid),
                float(Mood::Scales),
                special
            ]
            .boxed()
        }
    }
}

/// Extremes whose products and quotients are still normal numbers or overflow, since drivers may
/// flush denormal ones. Two are just below a power of two, where a driver's quotient may be above
/// it: one ends in a set bit, the other does not. The last two need the final step of `root`:
/// without it, the modelled driver's root of one is too low, of the other too high (only 8 numbers
/// in 1..4 have this property).
const SPECIAL: [f32; 15] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2e-8,
    -2e-8,
    1e30,
    -1e30,
    16_777_216.0,
    1.0 - f32::EPSILON / 2.0,
    1.0 - f32::EPSILON,
    2.657684,
    1.3810657,
];

fn unsigned(mood: Mood) -> BoxedStrategy<u32> {
    match mood {
        Mood::Cube | Mood::Grid => (0_u32..16).boxed(),
        Mood::Scales => (0_u32..16_384).boxed(),
        Mood::Any => prop_oneof![any::<u32>(), 0_u32..3].boxed(),
    }
}

fn signed_bits(mood: Mood) -> BoxedStrategy<u32> {
    match mood {
        Mood::Cube | Mood::Grid => (-8_i32..8).prop_map(|i| i as u32).boxed(),
        Mood::Scales => (-16_384_i32..16_384).prop_map(|i| i as u32).boxed(),
        Mood::Any => prop_oneof![any::<u32>(), 0_u32..3].boxed(),
    }
}
