//! The assembled WGSL of every technique, as users paste it.

use umbrage_techniques::{Hard, Pcf};
use umbrage_tests::assembled::{Assembled, PREFIX, all, assemble, compare, validate};

#[test]
fn texts_are_as_they_were() {
    let faults: Vec<String> = all().iter().filter_map(|a| a.check().err()).collect();
    assert!(
        faults.is_empty(),
        "{}\nif that is meant, look at the texts and run `cargo xtask bless NAME`",
        faults.join("\n")
    );
}

#[test]
fn every_text_has_an_owner() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/assembled");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| {
            entry
                .expect("readable")
                .file_name()
                .into_string()
                .expect("ASCII")
        })
        .collect();
    let mut owned: Vec<String> = all().iter().map(|a| format!("{}.wgsl", a.name)).collect();
    files.sort();
    owned.sort();
    assert_eq!(files, owned);
}

#[test]
fn naga_accepts_every_text() {
    for Assembled { name, text } in all() {
        validate(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(text.contains(&format!("fn {PREFIX}receive(r: {PREFIX}Receiver) -> f32")));
    }
    assert!(validate("fn f() -> f32 { return 1; } fn f() {}").is_err());
}

/// Two lights of different techniques in one shader, which has names of its own that the texts use, too.
#[test]
fn several_lights_fit_into_one_shader() {
    let sun = assemble(&Pcf::default(), "sun_");
    let lamp = assemble(&Hard::default(), "lamp_").replace("@group(0)", "@group(1)");
    let own =
        "fn tap() -> f32 { return sun_receive(sun_Receiver()) * lamp_receive(lamp_Receiver()); }";
    let whole = format!("{sun}\n{lamp}\n{own}");
    validate(&whole).unwrap_or_else(|e| panic!("{e}"));
    let without_prefix = format!("{}\n{own}", assemble(&Pcf::default(), ""));
    assert!(validate(&without_prefix).is_err());
}

#[test]
fn a_changed_line_is_caught() {
    assert_eq!(compare("a\nb\n", "a\nb\n"), Ok(()));
    assert_eq!(
        compare("a\nb\n", "a\nc\n"),
        Err("line 2 differs".to_owned())
    );
    assert!(compare("a\n", "a\nb\n").is_err());
}
