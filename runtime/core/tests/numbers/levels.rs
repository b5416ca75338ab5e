//! Functions that are compiled for a better processor than the rest (`bipedc_runtime::dispatch`).

/// What generated functions call at such a level.
const CALLED: [(&str, &str); 6] = [
    ("arrays.rs", include_str!("../../src/lanes/arrays.rs")),
    ("fused.rs", include_str!("../../src/lanes/fused.rs")),
    ("two.rs", include_str!("../../src/lanes/two.rs")),
    ("x86.rs", include_str!("../../src/lanes/x86.rs")),
    ("kernel.rs", include_str!("../../src/math/kernel.rs")),
    ("math/scalar.rs", include_str!("../../src/math/scalar.rs")),
];

/// No generated function calls these; large angles have time.
const OTHERS: [&str; 4] = ["eq", "fmt", "sin_cos_f64", "sin_cos_f32"];

/// Functions with a body, and the attributes in front of them.
fn functions(text: &str) -> Vec<(String, String)> {
    let (mut found, mut attributes) = (Vec::new(), String::new());
    for line in text.lines().map(str::trim) {
        if line.starts_with('#') {
            attributes.push_str(line);
        } else if let Some((_, after)) = line.split_once("fn ")
            && !line.starts_with("//")
        {
            let name = after.split(['(', '<']).next().unwrap_or_default();
            if line.ends_with('{') {
                found.push((name.to_owned(), std::mem::take(&mut attributes)));
            }
            attributes.clear();
        } else if !line.starts_with("//") {
            attributes.clear();
        }
    }
    found
}

/// One that stood by itself would be compiled for every x86-64: a call for each instruction of the better processor.
#[test]
fn all_that_is_called_at_a_level_is_part_of_the_caller() {
    let mut count = 0;
    for (file, text) in CALLED {
        for (name, attributes) in functions(text) {
            let aside = OTHERS.contains(&name.as_str()) || attributes.contains("#[cold]");
            let asked = attributes.contains("#[inline(always)]") || attributes.contains("#[$inline]");
            assert!(aside || asked, "{file}: {name} {attributes}");
            count += usize::from(asked);
        }
    }
    assert!(count > 60, "{count}");
    let arrays = CALLED[0].1;
    let lines: Vec<&str> = arrays.lines().filter(|line| line.starts_with("packed!(")).collect();
    let fused: Vec<&&str> = lines.iter().filter(|line| line.contains("fused")).collect();
    assert_eq!(fused.len(), 2);
    assert!(fused.iter().all(|line| line.starts_with("packed!(inline(always), ")));
}
