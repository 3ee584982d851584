use super::*;
use image::{ImageBuffer, Luma, Rgb, Rgba};
use std::io::Cursor;

fn read(image: &DynamicImage, meaning: Meaning) -> Texture {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("some.png");
    image.save(&path).unwrap();
    let texture = load_texture(&path, &crate::FilesOnDisk, meaning).unwrap();
    texture.validate().unwrap();
    texture
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
        (color.texels[1][0] - 0.215_861).abs() < 1e-6,
        "{:?}",
        color.texels
    );
    assert_eq!(color.texels[1][1..], [1.0, 0.0, 1.0]);
    assert_eq!(
        read(&image, Meaning::Data).texels[0],
        [128.0 / 255.0, 1.0, 0.0, 1.0]
    );
}

#[test]
fn alpha_is_the_files_own_or_its_first_channel() {
    let grey = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([51_u8])));
    assert_eq!(read(&grey, Meaning::Alpha).texels, [[1.0, 1.0, 1.0, 0.2]]);
    let leaf = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([255_u8, 9, 9, 51])));
    assert_eq!(read(&leaf, Meaning::Alpha).texels, [[1.0, 1.0, 1.0, 0.2]]);
}

#[test]
fn sixteen_bits_keep_their_precision() {
    let image = DynamicImage::from(ImageBuffer::from_fn(2, 1, |x, _| {
        Luma([32_768_u16 + x as u16])
    }));
    let heights = read(&image, Meaning::Data).texels;
    assert_eq!(
        [heights[0][0], heights[1][0]],
        [32_768.0 / 65535.0, 32_769.0 / 65535.0]
    );
    let colors = read(
        &DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([128_u16 * 257]))),
        Meaning::Color,
    );
    assert_eq!(
        colors.texels[0][0],
        picture::decode(128),
        "the same grey in 8 and in 16 bits"
    );
}

#[test]
fn alpha_is_not_encoded_and_rows_run_from_the_top() {
    let image = DynamicImage::from(ImageBuffer::from_fn(1, 2, |_, y| {
        Rgba([0, 0, 255 * y as u8, 128_u8])
    }));
    let texels = read(&image, Meaning::Color).texels;
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
        load_texture(&path, &crate::FilesOnDisk, Meaning::Color)
            .unwrap_err()
            .to_string()
    };
    assert!(message().contains("check the path"), "{}", message());
    std::fs::write(&path, b"GIF89a").unwrap();
    assert!(
        message().contains("can't be read as a PNG image"),
        "{}",
        message()
    );
    let image = DynamicImage::from(ImageBuffer::from_pixel(64, 64, Luma([7_u8])));
    image.save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(
        message().contains("can't be read as a PNG image"),
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
