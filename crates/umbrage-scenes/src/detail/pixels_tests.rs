use super::*;
use crate::detail::TextureFiles;
use image::{ImageBuffer, Luma, Rgb, Rgba};
use std::io::Cursor;
use umbrage_core::glam::Vec3;

/// Encodes an image as `some.png`, to be reduced to this side.
fn encoded(image: &DynamicImage, meaning: Meaning, color_side: u32) -> EncodedImage {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    EncodedImage {
        name: "some.png".to_owned(),
        bytes: bytes.into_inner(),
        format: ImageFormat::Png,
        meaning,
        color_side,
    }
}

fn read(image: &DynamicImage, meaning: Meaning) -> Texture {
    let texture = encoded(image, meaning, PICTURE_SIDE).texture().unwrap();
    texture.validate().unwrap();
    texture
}

/// An image of smooth colours, whose alpha is 0 in one texel.
fn smooth(width: u32, height: u32) -> DynamicImage {
    let wave = |i: u32, n: u32| {
        let turns = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        (128.0 + 100.0 * turns.sin()) as u8
    };
    DynamicImage::from(ImageBuffer::from_fn(width, height, |x, y| {
        let alpha = if (x, y) == (5, 3) { 0 } else { 255 };
        Rgba([wave(x, width), wave(y, height), 40, alpha])
    }))
}

#[test]
fn reduced_colors_are_those_of_the_whole_image() {
    let image = smooth(203, 96);
    let whole = read(&image, Meaning::Color);
    let reduced = encoded(&image, Meaning::Color, 64).texture().unwrap();
    assert_eq!(
        (whole.size, reduced.size),
        (UVec2::new(203, 96), UVec2::new(51, 24))
    );
    // Compare colours at the centres of the smaller texels.
    for (i, texel) in reduced.texels.iter().enumerate() {
        let at = UVec2::new(i as u32 % 51, i as u32 / 51);
        let share = (at.as_vec2() + 0.5) / reduced.size.as_vec2();
        let there = (share * whole.size.as_vec2()).as_uvec2();
        let expected = whole.texels.get((there.y * 203 + there.x) as usize);
        let off = Vec3::from_slice(&texel).distance(Vec3::from_slice(&expected));
        assert!(off < 0.04, "{at}: {texel:?}, {expected:?}");
    }
    // Light is averaged, not its encoding: black and white give 0.5, which is byte 188.
    let stripes = ImageBuffer::from_fn(4, 4, |x, _| Luma([255 * (x % 2) as u8]));
    let grey = encoded(&DynamicImage::from(stripes), Meaning::Color, 2).texture();
    let grey = grey.unwrap().texels;
    assert_eq!(grey, vec![[0.5, 0.5, 0.5, 1.0]; 4].into());
}

/// The colours of holes, often black or white, don't show at the rim of a reduced image.
#[test]
fn reduced_colors_of_alpha_tests_are_weighted_by_alpha() {
    let image = |alphas: [u8; 2]| {
        DynamicImage::from(ImageBuffer::from_fn(2, 2, |x, _| match x {
            0 => Rgba([255_u8, 0, 0, alphas[0]]),
            _ => Rgba([0, 255, 0, alphas[1]]),
        }))
    };
    let texel = |alphas, meaning| {
        let reduced = encoded(&image(alphas), meaning, 1).texture().unwrap();
        assert_eq!(reduced.size, UVec2::ONE);
        reduced.texels.get(0)
    };
    let [red, green, blue, alpha] = texel([255, 0], Meaning::CutOutColor);
    assert!(red > 0.999_99 && green < 2e-6, "{red}, {green}");
    assert_eq!([blue, alpha], [0.0, 0.5]);
    let [red, green, ..] = texel([255, 85], Meaning::CutOutColor);
    assert!((red - 0.75).abs() < 1e-5 && (green - 0.25).abs() < 1e-5);
    // Alpha of opaque surfaces is not used, and holes have the mean of their colours.
    assert_eq!(texel([255, 0], Meaning::Color), [0.5, 0.5, 0.0, 0.5]);
    assert_eq!(texel([0, 0], Meaning::CutOutColor), [0.5, 0.5, 0.0, 0.0]);
}

#[test]
fn alpha_tests_and_heights_keep_their_sizes() {
    let image = smooth(64, 48);
    for meaning in [Meaning::CutOut, Meaning::Alpha, Meaning::Heights] {
        let whole = encoded(&image, meaning, 8).texture().unwrap();
        assert_eq!(whole.size, UVec2::new(64, 48), "{meaning:?}");
        assert_eq!(whole.texels.get(3 * 64 + 5)[3], 0.0, "{meaning:?}");
    }
    // Without a hole, an alpha test is equal at any size.
    let opaque = DynamicImage::from(image.to_rgb8()).to_rgba8();
    let opaque = encoded(&DynamicImage::from(opaque), Meaning::CutOut, 0);
    let texture = opaque.texture().unwrap();
    assert_eq!((texture.size, texture.texels.get(0)[3]), (UVec2::ONE, 1.0));
}

#[test]
fn pending_images_name_the_first_that_fails() {
    let mut pending = PendingImages::default();
    let mut textures = Vec::new();
    for i in 0..40 {
        let mut image = encoded(&smooth(20 + i, 20), Meaning::Color, PICTURE_SIDE);
        if i % 16 == 7 {
            image.bytes.truncate(image.bytes.len() / 2);
        }
        assert_eq!(pending.add(image, &mut textures), i as usize);
    }
    let (index, _) = pending.decode(&mut textures).unwrap_err();
    assert_eq!(index, 7);
    let widths: Vec<u32> = textures[..7].iter().map(|texture| texture.size.x).collect();
    assert_eq!(widths, [20, 21, 22, 23, 24, 25, 26]);
}

#[test]
fn colours_are_decoded_once_and_data_never() {
    let image = DynamicImage::from(ImageBuffer::from_pixel(2, 1, Rgb([128_u8, 255, 0])));
    let color = read(&image, Meaning::Color);
    assert_eq!(
        (color.name.as_str(), color.size),
        ("some.png", UVec2::new(2, 1))
    );
    // Computed by hand from the formula of IEC 61966-2-1.
    assert!(
        (color.texels.get(1)[0] - 0.215_861).abs() < 1e-6,
        "{:?}",
        color.texels
    );
    assert_eq!(color.texels.get(1)[1..], [1.0, 0.0, 1.0]);
    assert_eq!(
        read(&image, Meaning::Heights).texels.get(0),
        [128.0 / 255.0, 1.0, 0.0, 1.0]
    );
}

#[test]
fn alpha_is_the_files_own_or_its_first_channel() {
    let alpha = |image: &DynamicImage| read(image, Meaning::Alpha).texels.get(0);
    let grey = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([51_u8])));
    assert_eq!(alpha(&grey), [1.0, 1.0, 1.0, 0.2]);
    let leaf = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([255_u8, 9, 9, 51])));
    assert_eq!(alpha(&leaf), [1.0, 1.0, 1.0, 0.2]);
}

#[test]
fn sixteen_bits_keep_their_precision() {
    let image = DynamicImage::from(ImageBuffer::from_fn(2, 1, |x, _| {
        Luma([32_768_u16 + x as u16])
    }));
    let heights = read(&image, Meaning::Heights).texels;
    assert_eq!(
        [heights.get(0)[0], heights.get(1)[0]],
        [32_768.0 / 65535.0, 32_769.0 / 65535.0]
    );
    let colors = read(
        &DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([128_u16 * 257]))),
        Meaning::Color,
    );
    assert_eq!(
        colors.texels.get(0)[0],
        picture::decode(128),
        "the same grey in 8 and in 16 bits"
    );
}

#[test]
fn alpha_is_not_encoded_and_rows_run_from_the_top() {
    let image = DynamicImage::from(ImageBuffer::from_fn(1, 2, |_, y| {
        Rgba([0, 0, 255 * y as u8, 128_u8])
    }));
    let texels: Vec<_> = read(&image, Meaning::Color).texels.iter().collect();
    assert_eq!(
        texels,
        [
            [0.0, 0.0, 0.0, 128.0 / 255.0],
            [0.0, 0.0, 1.0, 128.0 / 255.0]
        ]
    );
}

#[test]
fn what_is_no_png_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("some.png");
    let message = || {
        let mut files = TextureFiles::new(&crate::FilesOnDisk);
        let mut textures = Vec::new();
        let read = files.index(&path, Meaning::Color, &mut textures);
        let read = read.and_then(|_| files.decode(&mut textures));
        read.unwrap_err().to_string()
    };
    assert!(message().contains("check the path"), "{}", message());
    std::fs::write(&path, b"GIF89a").unwrap();
    assert!(
        message().contains("can't be read as a PNG or JPEG image"),
        "{}",
        message()
    );
    let image = DynamicImage::from(ImageBuffer::from_pixel(64, 64, Luma([7_u8])));
    image.save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(
        message().contains("can't be read as a PNG or JPEG image"),
        "{}",
        message()
    );
    DynamicImage::from(ImageBuffer::from_pixel(PICTURE_SIDE + 1, 1, Luma([7_u8])))
        .save(&path)
        .unwrap();
    assert!(
        message().contains("at most 8192 texels a side"),
        "{}",
        message()
    );
}

#[test]
fn a_palette_that_ends_within_a_colour_is_refused() {
    // A pixel of the palette's first colour, with correct checksums.
    const HEAD: &[u8] = b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x01\x00\x00\x00\x01\x08\x03\x00\x00\x00(\xcb4\xbb";
    const TAIL: &[u8] = b"\x00\x00\x00\x0aIDATx\x9cc`\x00\x00\x00\x02\x00\x01H\xaf\xa4q\x00\x00\x00\x00IEND\xaeB`\x82";
    let png = |palette: &[u8]| Cursor::new([HEAD, palette, TAIL].concat());
    let whole = decode_picture(
        png(b"\x00\x00\x00\x03PLTE\xff\x00\x00\x19\xe2\x097"),
        ImageFormat::Png,
    );
    assert_eq!(whole.unwrap().to_rgb8().into_raw(), [255, 0, 0]);
    let cut_short: [&[u8]; 2] = [
        b"\x00\x00\x00\x04PLTE\xff\x00\x00\x00j\xa6\xa8\x8b",
        b"\x00\x00\x00\x05PLTE\xff\x00\x00\x00\xff\x85\x00\xfc\x00",
    ];
    for cut in cut_short {
        let error = decode_picture(png(cut), ImageFormat::Png).unwrap_err();
        assert!(error.to_string().contains("not a multiple of 3"), "{error}");
    }
}
