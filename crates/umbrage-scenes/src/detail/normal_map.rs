//! Normal maps of height maps.

use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{Invalid, Texture, invalid};

/// Returns the tangent-space normal map, green up (OpenGL's convention), of the relief
/// `lambda (2 h - 1)`. The heights h are the first channel of `heights`. `square` is the size, in
/// metres, of the surface that the texture covers once, along u and along v.
///
/// Slopes are central differences over two texels, repeating at the borders. For the relief d, the
/// normal is `(-dd/dx, -dd/dy, 1)` over its length, y up the texture (Blinn 1978, "Simulation of
/// Wrinkled Surfaces"), stored as `(n + 1) / 2`.
///
/// # Errors
/// Returns an error if the texture is invalid, lambda is not finite, or a size is not above zero.
pub fn fitting_normal_map(
    heights: &Texture,
    lambda: f32,
    square: Vec2,
) -> Result<Texture, Invalid> {
    heights.validate()?;
    invalid::finite("lambda of the displacement", &[lambda])?;
    invalid::positive("size of the texture's square", square.x)?;
    invalid::positive("size of the texture's square", square.y)?;
    let width = heights.size.x as usize;
    let height = heights.size.y as usize;
    // The relief's difference is 2 lambda times the heights'; two texels are 2 / n of the square.
    let scale = heights.size.as_vec2() * lambda / square;
    let at = |x: usize, y: usize| heights.texels.get(y * width + x)[0];
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let right = at((x + 1) % width, y);
            let left = at((x + width - 1) % width, y);
            let below = at(x, (y + 1) % height);
            let above = at(x, (y + height - 1) % height);
            let along_u = right - left;
            let down = below - above;
            let normal = Vec3::new(-along_u * scale.x, down * scale.y, 1.0).normalize();
            texels.push(((normal + 1.0) * 0.5).extend(1.0).to_array());
        }
    }
    Ok(Texture {
        name: format!("normals of {}", heights.name),
        size: heights.size,
        texels: texels.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::glam::UVec2;

    /// One wave in each direction over 2 m x 1 m, heights 0 to 1.
    fn waves(n: u32) -> Texture {
        let wave = |i: u32| (f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::TAU;
        let h = |i: u32| 0.5 + 0.25 * (wave(i % n).sin() + wave(i / n).cos());
        Texture {
            name: "waves".to_owned(),
            size: UVec2::splat(n),
            texels: (0..n * n).map(|i| [h(i) as f32, 0.0, 0.0, 1.0]).collect(),
        }
    }

    /// The relief is `lambda (2 h - 1) = 0.05 (sin(tau u) + cos(tau v))` for lambda 0.1, u = x / 2,
    /// v = -y.
    fn exact(u: f64, v: f64) -> Vec3 {
        let tau = std::f64::consts::TAU;
        let dx = 0.05 * tau / 2.0 * (tau * u).cos();
        let dy = 0.05 * tau * (tau * v).sin();
        Vec3::new(-dx as f32, -dy as f32, 1.0).normalize()
    }

    fn worst(map: &Texture, expected: impl Fn(f64, f64) -> Vec3) -> f32 {
        let n = map.size.x;
        let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let stored = |t: [f32; 4]| Vec3::from_slice(&t) * 2.0 - 1.0;
        let pairs = (0..n * n).zip(map.texels.iter());
        pairs
            .map(|(i, t)| stored(t).distance(expected(centre(i % n), centre(i / n))))
            .fold(0.0, f32::max)
    }

    #[test]
    fn normals_are_those_of_the_surface() {
        let map = fitting_normal_map(&waves(64), 0.1, Vec2::new(2.0, 1.0)).unwrap();
        // Central differences have an error of (tau / 64)^2 / 6 for the slopes of sines, which are
        // up to 0.31.
        assert!(worst(&map, exact) < 6e-4, "{}", worst(&map, exact));
        // Negative controls: green down, and u for v.
        assert!(worst(&map, |u, v| exact(u, v) * Vec3::new(1.0, -1.0, 1.0)) > 0.3);
        assert!(worst(&map, |u, v| exact(v, u)) > 0.3);
    }

    #[test]
    fn finer_maps_are_better_by_the_square() {
        let error = |n| {
            worst(
                &fitting_normal_map(&waves(n), 0.1, Vec2::new(2.0, 1.0)).unwrap(),
                exact,
            )
        };
        let ratio = error(16) / error(64);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn flat_heights_give_the_flat_normal() {
        let flat = Texture {
            name: "flat".to_owned(),
            size: UVec2::new(1, 2),
            texels: vec![[0.3; 4]; 2].into(),
        };
        assert_eq!(
            fitting_normal_map(&flat, 9.0, Vec2::ONE).unwrap().texels,
            vec![[0.5, 0.5, 1.0, 1.0]; 2].into()
        );
    }

    #[test]
    fn senseless_sizes_are_refused() {
        assert!(fitting_normal_map(&waves(2), 0.1, Vec2::new(0.0, 1.0)).is_err());
        assert!(fitting_normal_map(&waves(2), f32::INFINITY, Vec2::ONE).is_err());
    }
}
