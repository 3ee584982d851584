use super::*;

const WALL: Bricks = Bricks {
    tile: 1.0,
    depth: 0.1,
};

fn texel(texture: &Texture, x: u32, y: u32) -> Vec3 {
    Vec3::from_slice(&texture.texels.get((y * texture.size.x + x) as usize))
}

#[test]
fn looks_are_valid_and_within_range() {
    for look in [
        matte(PALETTE[1]),
        glossy(PALETTE[2]),
        checker(),
        wood(),
        WALL.flat(),
        WALL.bumpy(),
        WALL.carve_surface(3),
    ] {
        look.material.validate(look.textures.len()).unwrap();
        for texture in &look.textures {
            texture.validate().unwrap();
            assert!(
                texture
                    .texels
                    .iter()
                    .flatten()
                    .all(|v| (0.0..=1.0).contains(&v)),
                "{}",
                texture.name
            );
            assert!(
                texture.texels.iter().any(|t| t != texture.texels.get(0)),
                "{} is plain",
                texture.name
            );
        }
    }
}

/// The lower rim of a brick slopes down: its normals point down, which is less than half in green.
/// The normals of the left rim point left, which is less than half in red.
#[test]
fn normals_lean_as_the_relief_does() {
    let textures = WALL.bumpy().textures;
    let normals = &textures[1];
    let courses: Vec<Vec3> = (0..32).map(|y| texel(normals, 32, y)).collect();
    let upper = courses[4];
    let lower = courses[27];
    assert!(
        upper.y > 0.6 && lower.y < 0.4,
        "{upper} above, {lower} below"
    );
    let left = texel(normals, 4, 16);
    let right = texel(normals, 59, 16);
    assert!(left.x < 0.4 && right.x > 0.6, "{left} left, {right} right");
    assert_eq!(courses[16], Vec3::new(0.5, 0.5, 1.0));
    assert!(
        normals
            .texels
            .iter()
            .all(|t| ((Vec3::from_slice(&t) * 2.0 - 1.0).length() - 1.0).abs() < 1e-5)
    );
}

#[test]
fn the_wall_repeats_without_a_seam() {
    let textures = WALL.carve_surface(3).textures;
    let heights = &textures[1];
    let last = heights.size.x - 1;
    for i in 0..=last {
        // A rim rises by 1 over .025 of 128 texels.
        let steepest = 1.0 / (0.025 * 128.0) + 1e-5;
        assert!(
            (texel(heights, 0, i) - texel(heights, last, i))
                .abs()
                .max_element()
                <= steepest,
            "row {i}"
        );
        assert!(
            (texel(heights, i, 0) - texel(heights, i, last))
                .abs()
                .max_element()
                <= steepest,
            "column {i}"
        );
    }
}
