//! Postures in which an impact pushes on every foot that it holds. Where what lands adds one row to what stands (the front toe, with the front heel and the rear toe on the
//! ground), the velocity just before it is settled by how fast it lands, so that the posture alone says how the impulses are shared out: Λ = −(J D⁻¹ Jᵀ)⁻¹ J v⁻ (4.22).
use super::demands::Demands;
use super::guess::Guess;
use super::layout::Layout;
use bipedc_compiler::compile::{Collocation, NodeRow};
use nalgebra::{DMatrix, DVector};

/// A posture at the end of a phase, before legs swap.
pub(super) struct LandingPosture {
    /// The phase by index.
    pub phase: usize,
    /// Positions; x of the base as it came.
    pub q: Vec<f64>,
    /// Distance from the foot behind to the one in front, m.
    pub step: f64,
    /// Least of the impulses that a landing at 1 m/s leaves to friction and to the ends of soles, N s; negative where it would pull, slip or tip.
    pub reserve: f64,
}

/// Ways that are tried from the first posture, and random moves of each.
const WAYS: u64 = 4;
const MOVES: usize = 300;
/// Size of a first move, rad, and of the smallest.
const SIZES: [f64; 2] = [0.3, 1e-3];
/// How much more than what is asked for a landing at the fastest speed is to leave.
pub(super) const ENOUGH: f64 = 2.0;

/// The change behind a phase with what its postures are to keep.
struct Landing<'a> {
    of: &'a Collocation,
    layout: &'a Layout,
    phase: usize,
    demands: &'a Demands,
    /// Height of the base at ease, m.
    height: f64,
    /// Of all coordinates.
    limits: Vec<[f64; 2]>,
}

/// Whether a phase ends with a landing whose impulses the posture alone settles.
pub fn lands_by_posture(of: &Collocation) -> bool {
    phase_of(of).is_some()
}

/// The first phase that stands on several points and ends with an impact that holds one row more.
fn phase_of(of: &Collocation) -> Option<usize> {
    let settled = |&p: &usize| {
        let (phase, change) = (&of.phases[p], &of.changes[p]);
        phase.standing.len() > 1 && change.impulses.len() == phase.forces.len() + 1
    };
    (0..of.phases.len()).find(settled)
}

/// The posture found from that of the guess; none: there is no such phase.
pub(super) fn posture(
    of: &Collocation,
    layout: &Layout,
    demands: &Demands,
    guess: &Guess,
) -> Option<LandingPosture> {
    let phase = phase_of(of)?;
    let last = layout.motion(phase, layout.phases[phase].nodes() - 1, 0);
    let landing = Landing::new(of, layout, phase, (demands, guess.height));
    landing.found(&guess.x[last..last + layout.nv])
}

/// Positions after the change behind a phase.
pub(super) fn relabelled(of: &Collocation, phase: usize, q: &[f64]) -> Vec<f64> {
    match of.changes[phase].relabel {
        true => of.relabelling.iter().map(|&(from, sign)| sign * q[from]).collect(),
        false => q.to_vec(),
    }
}

impl<'a> Landing<'a> {
    fn new(
        of: &'a Collocation,
        layout: &'a Layout,
        phase: usize,
        (demands, height): (&'a Demands, f64),
    ) -> Self {
        let mut limits = vec![[-10.0, 10.0]; layout.nv];
        limits[2] = [-super::variables::LEAN, super::variables::LEAN];
        for joint in &of.tree.joints {
            let named = of.description.joints.iter().find(|other| other.name == joint.name);
            let (low, high) = named.and_then(|joint| joint.position_limits).unwrap_or((-3.2, 3.2));
            limits[joint.v_index] = super::mirrored::between([low, high], demands.joint);
        }
        Self { of, layout, phase, demands, height, limits }
    }

    /// Climbs from a posture by random moves that keep the feet on the ground, the same every time, until the landing leaves enough.
    fn found(&self, from: &[f64]) -> Option<LandingPosture> {
        let enough = ENOUGH * self.demands.impulse / self.demands.landing[1];
        let begin = self.settled(from.to_vec()).unwrap_or_else(|| from.to_vec());
        let mut best = (self.reserve(&begin).unwrap_or(f64::NEG_INFINITY), begin.clone());
        for way in 1..=WAYS {
            let found = self.climbed(&begin, way, enough);
            if found.0 > best.0 {
                best = found;
            }
            if best.0 >= enough {
                break;
            }
        }
        let (reserve, q) = best;
        let step = self.step(&q);
        reserve.is_finite().then_some(LandingPosture { phase: self.phase, q, step, reserve })
    }

    fn climbed(&self, begin: &[f64], seed: u64, enough: f64) -> (f64, Vec<f64>) {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let mut best = (self.reserve(begin).unwrap_or(f64::NEG_INFINITY), begin.to_vec());
        let mut size = SIZES[0];
        for _ in 0..MOVES {
            let moved = best.1.iter().map(|x| x + size * random()).collect();
            let Some(q) = self.settled(moved) else { continue };
            let Some(reserve) = self.reserve(&q) else { continue };
            if reserve > best.0 {
                (best, size) = ((reserve, q), size * 1.5);
            } else {
                size = (size * 0.97).max(SIZES[1]);
            }
            if best.0 >= enough {
                break;
            }
        }
        best
    }

    /// The nearest posture within the limits in which what stands and what lands is on the ground; none: there is none near, feet go too high or below the ground, or the
    /// one that lands is not in front.
    fn settled(&self, mut q: Vec<f64>) -> Option<Vec<f64>> {
        let (standing, landing) =
            (&self.of.phases[self.phase].standing, &self.of.changes[self.phase].landing);
        let ground: Vec<usize> = standing.iter().chain(landing).copied().collect();
        let near = 1e-9 * self.height;
        for _ in 0..25 {
            q.iter_mut().zip(&self.limits).for_each(|(q, &[low, high])| *q = q.clamp(low, high));
            let (heights, slopes) = self.rows(&q, NodeRow::Height, 0);
            let wrong = DVector::from_iterator(ground.len(), ground.iter().map(|&k| -heights[k]));
            if wrong.amax() < near {
                let within = heights.iter().all(|h| (-10.0 * near..=0.3 * self.height).contains(h));
                let forward = self.step(&q) > 0.05 * self.height && q[1] > 0.6 * self.height;
                return (within && forward).then_some(q);
            }
            let slopes = DMatrix::from_fn(ground.len(), q.len(), |i, k| slopes[(ground[i], k)]);
            let soft = DMatrix::identity(ground.len(), ground.len()) * (1e-9 * self.height * self.height);
            let step = (&slopes * slopes.transpose() + soft).lu().solve(&wrong)?;
            q.iter_mut().zip((slopes.transpose() * step).iter()).for_each(|(q, d)| *q += d);
        }
        None
    }

    /// From the toe that stands to the one that lands, m.
    fn step(&self, q: &[f64]) -> f64 {
        let (places, _) = self.rows(q, NodeRow::Place, 0);
        let behind =
            self.of.phases[self.phase].standing.iter().map(|&k| places[k]).fold(f64::INFINITY, f64::min);
        places[self.of.changes[self.phase].landing[0]] - behind
    }

    /// What [`LandingPosture::reserve`] says.
    fn reserve(&self, q: &[f64]) -> Option<f64> {
        let impulses = self.impulses(q, &self.approach(q)?)?;
        let of_foot = |foot: &bipedc_runtime::control::StandingFoot| {
            let [x, z] = foot.force.map(|k| impulses[k]);
            let push = z.min(self.demands.impact_friction * z - x.abs());
            foot.moment.map_or(push, |k| {
                let [rear, front] = foot.sole;
                let ends = (z * front - impulses[k]).min(impulses[k] - z * rear);
                push.min(ends / (front - rear))
            })
        };
        let feet = self.of.changes[self.phase].feet.iter().flatten();
        Some(feet.map(of_foot).fold(f64::INFINITY, f64::min))
    }

    /// The smallest velocity at which what stands does so and the point that lands comes down at 1 m/s.
    fn approach(&self, q: &[f64]) -> Option<Vec<f64>> {
        let (_, holds) = self.rows(q, NodeRow::Contact, 2);
        let (_, rates) = self.rows(q, NodeRow::HeightRate, 1);
        let landing = self.of.changes[self.phase].landing[0];
        let all = DMatrix::from_fn(holds.nrows() + 1, q.len(), |i, k| match i < holds.nrows() {
            true => holds[(i, k)],
            false => rates[(landing, k)],
        });
        let mut wanted = DVector::zeros(all.nrows());
        wanted[holds.nrows()] = -1.0;
        let found = all.transpose() * (&all * all.transpose()).lu().solve(&wanted)?;
        Some(found.iter().copied().collect())
    }

    /// Impulses of the change at this posture and velocity: its momentum rows and what it holds are linear in v⁺ and Λ.
    fn impulses(&self, q: &[f64], v: &[f64]) -> Option<Vec<f64>> {
        let (of, nv) = (&self.of.changes[self.phase], self.layout.nv);
        let asked = nv + of.impulses.len();
        let mut x = vec![0.0; of.function.variables()];
        x[..nv].copy_from_slice(q);
        x[nv..2 * nv].copy_from_slice(v);
        x[2 * nv..3 * nv].copy_from_slice(&relabelled(self.of, self.phase, q));
        let mut values = vec![0.0; of.function.rows()];
        of.function.values(&x, &mut values);
        let structure = of.function.jacobian_structure();
        let mut slopes = vec![0.0; structure.len()];
        of.function.jacobian(&x, &mut slopes);
        let mut matrix = DMatrix::zeros(asked, asked);
        for (&[row, variable], slope) in structure.iter().zip(slopes) {
            if (nv..nv + asked).contains(&row) && variable >= 3 * nv {
                matrix[(row - nv, variable - 3 * nv)] += slope;
            }
        }
        let wrong = DVector::from_iterator(asked, values[nv..nv + asked].iter().map(|x| -x));
        let found = matrix.lu().solve(&wrong)?;
        let impulses: Vec<f64> = found.iter().skip(nv).copied().collect();
        impulses.iter().all(|x| x.is_finite()).then_some(impulses)
    }

    /// Rows of a kind at a posture at rest, with their slopes by q, v or v̇ (order 0, 1, 2).
    fn rows(&self, q: &[f64], kind: NodeRow, order: usize) -> (DVector<f64>, DMatrix<f64>) {
        let (of, nv) = (&self.of.phases[self.phase], self.layout.nv);
        let mut x = vec![0.0; of.node.variables()];
        x[..nv].copy_from_slice(q);
        x[3 * nv + 1] = 1.0;
        let mut values = vec![0.0; of.node.rows()];
        of.node.values(&x, &mut values);
        let structure = of.node.jacobian_structure();
        let mut slopes = vec![0.0; structure.len()];
        of.node.jacobian(&x, &mut slopes);
        let place = of.rows.iter().find(|row| row.0 == kind);
        let (first, count) = place.map_or((0, 0), |&(_, first, count)| (first, count));
        let mut jacobian = DMatrix::zeros(count, nv);
        for (&[row, variable], slope) in structure.iter().zip(slopes) {
            if (first..first + count).contains(&row) && (order * nv..(order + 1) * nv).contains(&variable) {
                jacobian[(row - first, variable - order * nv)] += slope;
            }
        }
        (DVector::from_column_slice(&values[first..first + count]), jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::super::guess::{height, naive};
    use super::super::impulse_that_lands;
    use super::super::tests::form;
    use super::*;

    fn landing<'a>(of: &'a Collocation, layout: &'a Layout, demands: &'a Demands) -> Landing<'a> {
        Landing::new(of, layout, phase_of(of).unwrap(), (demands, height(of)))
    }

    /// Seven links: the toe of the front foot lands at the end of the third phase. Other velocities that hold what stands and land as fast have the same impulses,
    /// twice the speed twice the impulses.
    #[test]
    fn the_posture_alone_settles_how_a_toe_lands() {
        let of = form("seven_link_v1", "collocated");
        let (layout, demands) = (Layout::new(&of, &[1; 4]), Demands::new(0.4));
        let it = landing(&of, &layout, &demands);
        assert_eq!(it.phase, 2);
        let guess = naive(&of, &layout, 0.4, 0);
        let last = layout.motion(2, layout.phases[2].nodes() - 1, 0);
        let q = it.settled(guess.x[last..last + layout.nv].to_vec()).unwrap();
        let v = it.approach(&q).unwrap();
        let impulses = it.impulses(&q, &v).unwrap();
        let twice: Vec<f64> = v.iter().map(|v| 2.0 * v).collect();
        let of_twice = it.impulses(&q, &twice).unwrap();
        // A motion that leaves the contacts and the landing toe as they are.
        let (_, holds) = it.rows(&q, NodeRow::Contact, 2);
        let (_, rates) = it.rows(&q, NodeRow::HeightRate, 1);
        let toe = of.changes[2].landing[0];
        let all = DMatrix::from_fn(holds.nrows() + 1, q.len(), |i, k| {
            if i < holds.nrows() { holds[(i, k)] } else { rates[(toe, k)] }
        });
        let any = DVector::from_fn(q.len(), |k, _| (k as f64 + 1.0).sin());
        let along = all.transpose() * (&all * all.transpose()).lu().solve(&(&all * &any)).unwrap();
        let free = any - along;
        assert!(free.amax() > 0.1, "{free}");
        let other: Vec<f64> = v.iter().zip(free.iter()).map(|(v, free)| v + free).collect();
        let of_other = it.impulses(&q, &other).unwrap();
        for (k, impulse) in impulses.iter().enumerate() {
            assert!((of_other[k] - impulse).abs() < 1e-9, "{impulses:?} {of_other:?}");
            assert!((of_twice[k] - 2.0 * impulse).abs() < 1e-9, "{impulses:?} {of_twice:?}");
        }
    }

    /// The posture that is found is on the ground, within the limits of the joints, and leaves what is asked for; that of the guess does not.
    #[test]
    fn a_posture_is_found_in_which_every_foot_is_pushed() {
        let of = form("seven_link_v1", "collocated");
        let (layout, demands) = (Layout::new(&of, &[1; 4]), Demands::of_size(0.4, [19.0, 0.6, 9.81]));
        let it = landing(&of, &layout, &demands);
        let guess = naive(&of, &layout, 0.4, 0);
        let last = layout.motion(2, layout.phases[2].nodes() - 1, 0);
        let usual = it.settled(guess.x[last..last + layout.nv].to_vec()).unwrap();
        assert!(it.reserve(&usual).unwrap() < 0.0);
        let found = posture(&of, &layout, &demands, &guess).unwrap();
        assert!(found.reserve * demands.landing[1] >= demands.impulse, "{}", found.reserve);
        assert_eq!(found.reserve, it.reserve(&found.q).unwrap());
        let (heights, _) = it.rows(&found.q, NodeRow::Height, 0);
        for &point in of.phases[2].standing.iter().chain(&of.changes[2].landing) {
            assert!(heights[point].abs() < 1e-8, "{heights}");
        }
        for (q, [low, high]) in found.q.iter().zip(&it.limits) {
            assert!((low..=high).contains(&q), "{:?}", found.q);
        }
    }

    /// What a landing can push with is asked for as it is; of more than any posture pushes with, a half of that is left. Who has no such landing is asked for anything.
    #[test]
    fn no_more_is_asked_for_than_a_landing_can_push_with() {
        let of = form("seven_link_v1", "collocated");
        let usual = Demands::of_size(0.4, [19.0, 0.6, 9.81]);
        assert_eq!(impulse_that_lands(&of, &usual), Some(usual.impulse));
        let large = Demands { impulse: 30.0, ..usual.clone() };
        let possible = impulse_that_lands(&of, &large).unwrap();
        assert!(possible > 0.0 && possible < 15.0, "{possible} N s");
        // The posture that pushes most keeps what is left, by far.
        assert_eq!(impulse_that_lands(&of, &Demands { impulse: possible, ..large }), Some(possible));
        assert_eq!(impulse_that_lands(&form("five_link", "optimised"), &usual), None);
    }
}
