//! `[ground]` of a scenario.
use super::file::Soil;
use super::reading::{NOT_NEGATIVE, POSITIVE, Reading};
use crate::simulate::{Compliance, Cone, Ground};

impl Reading<'_> {
    pub(super) fn ground(&mut self, soil: Option<&Soil>) -> Ground {
        let none = Soil::default();
        let (soil, fine) = (soil.unwrap_or(&none), Ground::default());
        let unit = (0.0, 1.0);
        let cone = match soil.cone.as_ref().map(|cone| cone.get_ref().as_str()) {
            None | Some("round") => Cone::Round,
            Some("pyramid") => Cone::Pyramid,
            Some(other) => {
                let at = soil.cone.as_ref().map_or(0, |cone| cone.span().start);
                self.wrong::<()>(
                    at,
                    format!("there is no cone \"{other}\""),
                    "write \"round\" or \"pyramid\"",
                );
                Cone::Round
            }
        };
        let compliance = match &soil.stiffness {
            Some(stiffness) => Some(Compliance {
                stiffness: self.number("stiffness", Some(stiffness), 1.0, POSITIVE, "N/m"),
                damping: self.number("damping", soil.damping.as_ref(), 0.0, NOT_NEGATIVE, "N s/m"),
            }),
            None => {
                if let Some(damping) = &soil.damping {
                    let at = damping.span().start;
                    self.wrong::<()>(
                        at,
                        "`damping` of a ground without `stiffness`",
                        "add `stiffness` in N/m",
                    );
                }
                None
            }
        };
        Ground {
            friction: self.number("friction", soil.friction.as_ref(), fine.friction, NOT_NEGATIVE, "1"),
            normal_restitution: self.number("restitution", soil.restitution.as_ref(), 0.0, unit, "1"),
            tangential_restitution: self.number(
                "tangential_restitution",
                soil.tangential_restitution.as_ref(),
                0.0,
                (-1.0, 1.0),
                "1",
            ),
            cone,
            compliance,
            recovery: self.number("recovery", soil.recovery.as_ref(), 0.0, NOT_NEGATIVE, "1/s"),
        }
    }
}
