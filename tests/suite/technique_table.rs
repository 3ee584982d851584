//! Test of the README's list of techniques.

use umbrage_tests::technique_table::{check, path, table, with_table};

#[test]
fn the_readme_lists_every_technique() {
    if let Err(why) = check() {
        panic!("{why}\nrewrite it: `cargo xtask bless techniques`");
    }
}

#[test]
fn a_stale_table_is_caught() {
    let readme = std::fs::read_to_string(path()).expect("it is there");
    let fresh = with_table(&readme, &table()).expect("it has marks");
    let stale = fresh.replacen("| `pcf` |", "| `pfc` |", 1);
    assert!(stale != fresh, "there is a `pcf` to spoil");
    assert!(with_table(&stale, &table()).is_ok_and(|updated| updated == fresh));
    assert!(with_table("no marks", &table()).is_err());
}
