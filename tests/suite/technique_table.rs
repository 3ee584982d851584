//! The README lists the techniques that there are.

use umbrage_tests::technique_table::{check, path, table, with_table};

#[test]
fn the_readme_lists_every_technique() {
    if let Err(why) = check() {
        panic!("{why}\nto write it anew: `cargo xtask bless techniques`");
    }
}

#[test]
fn a_stale_table_is_caught() {
    let text = std::fs::read_to_string(path()).expect("it is there");
    let stale = text.replacen("| `pcf` |", "| `pfc` |", 1);
    assert_ne!(with_table(&stale, &table()).expect("it has marks"), stale);
    assert_eq!(with_table(&stale, &table()).expect("it has marks"), text);
    assert!(with_table("no marks", &table()).is_err());
}
