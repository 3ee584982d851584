//! Evaluation of points at other pixels than those that show them. Only what follows the pixel (a
//! dither pattern, rotated taps, random rays) changes.

use umbrage_core::Receivers;

/// Returns the receivers with each row moved to the right by this many pixels, wrapping around.
pub fn to_the_right(receivers: &Receivers, pixels: usize) -> Receivers {
    let mut out = receivers.clone();
    let width = receivers.size.x;
    for numbers in [
        &mut out.x,
        &mut out.y,
        &mut out.z,
        &mut out.nx,
        &mut out.ny,
        &mut out.nz,
        &mut out.depth,
        &mut out.distance,
    ] {
        rotate(numbers, width, pixels);
    }
    // Empty unless requested.
    rotate(&mut out.shading_normals, width, pixels);
    rotate(&mut out.triangle, width, pixels);
    rotate(&mut out.receives, width, pixels);
    out
}

/// Moves each row of such a mask, `width` pixels wide, back to the left.
pub fn shift_back(mask: &mut [f32], width: u32, pixels: usize) {
    let width = width as usize;
    for row in mask.chunks_mut(width) {
        row.rotate_left(pixels % width);
    }
}

fn rotate<T>(values: &mut [T], width: u32, pixels: usize) {
    let width = width as usize;
    for row in values.chunks_mut(width) {
        row.rotate_right(pixels % width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn rows_move_and_come_back() {
        let mut receivers = Receivers::empty(UVec2::new(3, 2));
        receivers.x = vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        receivers.receives[4] = true;
        let moved = to_the_right(&receivers, 1);
        assert_eq!(moved.x, [2.0, 0.0, 1.0, 5.0, 3.0, 4.0]);
        assert!(moved.receives[5] && !moved.receives[4]);
        let mut mask = moved.x;
        shift_back(&mut mask, 3, 1);
        assert_eq!(mask, receivers.x);
        // Moving by a whole row changes nothing.
        assert_eq!(to_the_right(&receivers, 3), receivers);
    }
}
