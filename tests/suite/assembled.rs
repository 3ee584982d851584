//! Tests of the assembled WGSL of every technique, as users paste it.

use umbrage_techniques::{Hard, MapTechnique, Pcf};
use umbrage_tests::assembled::{
    Assembled, PREFIX, all, assemble, difference, kept_checksums, validate,
};

#[test]
fn texts_are_as_they_were() {
    let faults: Vec<String> = all().iter().filter_map(|a| a.check().err()).collect();
    assert!(
        faults.is_empty(),
        "{}\nif that is meant, run `cargo xtask bless NAME`",
        faults.join("\n")
    );
}

#[test]
fn every_checksum_has_a_technique() {
    let kept = kept_checksums().expect("readable");
    let mut owned: Vec<String> = all().into_iter().map(|a| a.name).collect();
    owned.sort();
    let names: Vec<&String> = kept.iter().map(|(name, _)| name).collect();
    assert_eq!(names, owned.iter().collect::<Vec<_>>());
}

#[test]
fn naga_accepts_every_text() {
    for Assembled { name, text } in all() {
        validate(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(text.contains(&format!("fn {PREFIX}receive(r: {PREFIX}Receiver) -> f32")));
    }
    assert!(validate("fn f() -> f32 { return 1; } fn f() {}").is_err());
}

/// Two lights of different techniques fit into one shader, which also declares names that the texts
/// use.
#[test]
fn several_lights_fit_into_one_shader() {
    let sun = assemble(&MapTechnique::<Pcf>::default(), "sun_");
    let lamp =
        assemble(&MapTechnique::<Hard>::default(), "lamp_").replace("@group(0)", "@group(1)");
    let own =
        "fn tap() -> f32 { return sun_receive(sun_Receiver()) * lamp_receive(lamp_Receiver()); }";
    let whole = format!("{sun}\n{lamp}\n{own}");
    validate(&whole).unwrap_or_else(|e| panic!("{e}"));
    let without_prefix = format!("{}\n{own}", assemble(&MapTechnique::<Pcf>::default(), ""));
    assert!(validate(&without_prefix).is_err());
}

#[test]
fn a_changed_line_is_caught_and_shown() {
    let mut changed = all().remove(0);
    assert_eq!(changed.check(), Ok(()));
    changed.text = changed.text.replacen("return", "return  ", 1);
    let why = changed.check().expect_err("another text");
    let marked: Vec<char> = why.lines().filter_map(|line| line.chars().next()).collect();
    assert_eq!(marked.iter().filter(|c| **c == '+').count(), 2, "{why}");
    assert!(why.contains("+    return  "), "{why}");
    assert_eq!(difference("a\nb\n", "a\nb\n"), "");
}
