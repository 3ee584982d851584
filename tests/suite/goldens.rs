//! Tests of golden images.

use umbrage_tests::golden::{Golden, MAX_BYTES, SIDE, all, compare, encode};

#[test]
fn masks_are_as_they_were() {
    let faults: Vec<String> = all().iter().filter_map(|g| g.check().err()).collect();
    assert!(
        faults.is_empty(),
        "{}\nif that is meant, look at the images and run `cargo xtask bless NAME`",
        faults.join("\n")
    );
}

#[test]
fn every_golden_image_has_an_owner_and_shows_a_shadow() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/goldens");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|e| e.expect("readable").path())
        .collect();
    let mut owned: Vec<_> = all().iter().map(Golden::path).collect();
    files.sort();
    owned.sort();
    assert_eq!(files, owned);
    for path in files {
        let image = image::open(&path).expect("a PNG").into_luma8();
        let dark = image.pixels().filter(|p| p.0[0] < 128).count();
        assert!(
            dark > 20 && dark < image.len() - 20,
            "{}: {dark} dark pixels of {}",
            path.display(),
            image.len()
        );
    }
}

#[test]
fn one_changed_pixel_is_caught() {
    let image = image::GrayImage::from_fn(SIDE, SIDE, |x, y| image::Luma([(x ^ y) as u8]));
    let png = encode(&image).expect("it encodes");
    compare(&png, &image).expect("the same image");
    let mut spoilt = image.clone();
    spoilt.get_pixel_mut(77, 5).0[0] ^= 1;
    assert!(compare(&png, &spoilt).is_err());
    assert!(
        compare(
            &encode(&image::GrayImage::new(SIDE, SIDE - 1)).expect("it encodes"),
            &image
        )
        .is_err()
    );
    assert!(compare(b"no PNG", &image).is_err());
}

#[test]
fn a_large_file_is_caught() {
    // Use noise, which doesn't compress.
    let mut state = 1_u32;
    let image = image::GrayImage::from_fn(SIDE, SIDE, |_, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        image::Luma([(state >> 24) as u8])
    });
    let png = encode(&image).expect("it encodes");
    assert!(png.len() > MAX_BYTES);
    assert!(compare(&png, &image).is_err());
}
