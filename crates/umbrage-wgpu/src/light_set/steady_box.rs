//! A box that doesn't change when its contents move a little.

use glam::Vec3;
use umbrage_core::Aabb;

/// Step of the grid, as a fraction of the box's longest side. Each side is extended by between half
/// of it and all of it.
const STEP: f32 = 1.0 / 16.0;

/// Returns a box around `bounds` whose sides are on a grid. It only depends on `bounds`, so two
/// sets with the same casters have the same box. The step of the grid is a power of two.
pub(crate) fn steady_box_around(bounds: &Aabb) -> Aabb {
    if bounds.is_empty() {
        return Aabb::EMPTY;
    }
    let longest = bounds.extent().max_element();
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    // A step must be wider than the spacing of floats at the box.
    let least = (farthest * f32::EPSILON * 4.0).max(f32::MIN_POSITIVE);
    let step = (longest * STEP).max(least).log2().floor().exp2();
    let down = |v: Vec3| (v / step).floor() * step;
    let around = Aabb {
        min: down(bounds.min),
        max: -down(-bounds.max),
    };
    if around.validate().is_ok() {
        around
    } else {
        *bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_moves_leave_it_alone_and_it_holds_all() {
        let at = |x: f32| Aabb {
            min: Vec3::new(x, 0.1, -3.0),
            max: Vec3::new(x + 10.0, 2.2, 5.0),
        };
        let held = steady_box_around(&at(0.1));
        for x in [0.1, 0.15, 0.2, 0.3, 0.4] {
            assert_eq!(steady_box_around(&at(x)), held, "{x}");
        }
        for x in [-1e5, -3.3, 0.0, 0.7, 12_345.678, 1e6] {
            let inner = at(x);
            let outer = steady_box_around(&inner);
            assert!(outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all());
            let added = outer.extent() - inner.extent();
            assert!(
                added.max_element() <= 2.0 * 10.0 * STEP + 0.5,
                "{x}: {added}"
            );
        }
        assert_eq!(steady_box_around(&Aabb::EMPTY), Aabb::EMPTY);
    }
}
