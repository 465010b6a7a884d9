//! What is known to be wrong and not yet mended, one failing test each.
//!
//! A test here states what should hold, says in its doc comment what happens instead and why, and is marked
//! `#[ignore = "..."]` so that the suite passes; `cargo test --test known_issues -- --ignored` runs them all. Whoever
//! mends one moves its test to where the mended thing is tested. An empty file means that nothing is known.
