//! `shapes` of `[ground]`: which links touch the ground besides the feet.
use super::file::Soil;
use super::reading::Reading;
use crate::robot::BaseKind;
use crate::simulate::Plant;
use bipedc_effects::spelling::suggest;
use toml::Value;

/// Links that touch the ground with the shapes of the description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shapes {
    /// By name; `None`: all that have a shape and are no foot.
    pub links: Option<Vec<String>>,
    /// Line and column.
    pub position: (usize, usize),
}

impl Reading<'_> {
    /// What is said of them; `None`: feet alone touch the ground.
    pub(super) fn shapes(&mut self, soil: Option<&Soil>, plant: &Plant) -> Option<Shapes> {
        let found = soil?.shapes.as_ref()?;
        let at = found.span().start;
        let position = self.place(at);
        let links = match found.get_ref() {
            Value::Boolean(false) => return None,
            Value::Boolean(true) => None,
            Value::Array(list) => {
                let names: Option<Vec<&str>> = list.iter().map(Value::as_str).collect();
                let Some(names) = names else { return self.no_shapes(at) };
                for name in names.iter().filter(|name| !plant.links.iter().any(|link| link == *name)) {
                    let otherwise = || format!("links: {}", plant.links.join(", "));
                    let help = suggest(name, plant.links.iter().map(String::as_str), otherwise);
                    self.wrong::<()>(at, format!("the robot has no link `{name}`"), help);
                }
                Some(names.into_iter().map(str::to_owned).collect())
            }
            _ => return self.no_shapes(at),
        };
        if plant.layout.base == BaseKind::Fixed {
            let message = "`shapes` on a stand: the robot hangs in the air and touches no ground";
            return self.wrong(at, message, "leave it out, or choose --base floating or planar");
        }
        Some(Shapes { links, position })
    }

    fn no_shapes<T>(&mut self, at: usize) -> Option<T> {
        let help = "write shapes = true (all links but the feet), or a list of links, such as [\"torso\"]";
        self.wrong(at, "`shapes` is not possible", help)
    }
}
