//! What the controller of walks takes itself to carry, and how it learns that.
use super::controller::WalkingController;
use super::gains::Gains;
use super::motion::Motion;
use super::payload::Payload;
use super::payload_observer::{PayloadObserver, Seen, in_world, on_sole};
use super::robot::Place;
use super::space::{Vector, zero};
use crate::control::Observation;
use crate::real::Scalar;

impl<M, R: Scalar> WalkingController<M, R> {
    /// What it carries on its root link that the model does not know; what is not finite is not heard.
    pub fn carry(&mut self, payload: Payload<R>) {
        if payload.mass.is_finite() && payload.moment.iter().all(|x| x.is_finite()) {
            self.payload = payload;
        }
    }

    /// What it takes itself to carry.
    pub fn payload(&self) -> &Payload<R> {
        &self.payload
    }

    /// How well what it carries is known: standard deviations of the mass (kg) and the first moment (kg m); `None`: it does not learn.
    pub fn payload_deviations(&self) -> Option<(R, Vector<R>)> {
        self.observer.as_ref().map(PayloadObserver::deviations)
    }

    /// Whether to find out what it carries while it walks, from loads and centres of pressure of its feet.
    pub fn learn_payload(&mut self, learns: bool) {
        let Gains { touch, height, .. } = self.gains;
        // A foot touches from a tenth of the weight on.
        let made =
            || PayloadObserver::new(R::constant(10.0) * touch, R::constant(0.5) * height, self.robot.gravity);
        self.observer = learns.then(made);
    }

    /// What feet feel is not known: filters begin anew.
    pub(super) fn pause_learning(&mut self) {
        self.observer.iter_mut().for_each(PayloadObserver::pause);
    }

    /// Learns from what feet feel what the robot carries.
    pub(super) fn learn(
        &mut self,
        observed: &Observation<'_, R>,
        (place, center): (&Place<R>, Vector<R>),
        loads: Option<[R; 2]>,
        step: R,
    ) {
        let Some(observer) = &mut self.observer else { return };
        let feet = self.robot.legs.iter().zip(&place.soles).zip(loads.unwrap_or([R::constant(f64::NAN); 2]));
        let mut pressed = [(zero(), R::constant(f64::NAN)); 2];
        for (found, ((leg, sole), load)) in pressed.iter_mut().zip(feet) {
            let center = observed.centers.get(leg.foot).and_then(|center| on_sole(&leg.sole, *center));
            // Where next to nothing presses it does not matter.
            let light = load < R::constant(0.1) * self.gains.touch;
            if let Some(on_sole) = center.or(light.then_some([R::constant(0.0); 2])) {
                *found = (in_world(&sole.pose, on_sole), load);
            }
        }
        // Ten times the weight is no load.
        let most = R::constant(100.0) * self.gains.touch;
        if !pressed.iter().all(|(_, load)| load.abs() < most) {
            observer.pause();
            return;
        }
        let Motion { momentum, modelled: mass, .. } = self.motion;
        let seen = Seen {
            base: place.base,
            v: observed.v,
            momentum,
            mass,
            center,
            gravity: self.robot.gravity,
            pressed,
        };
        observer.update(&seen, step);
        let Payload { mass: found, moment } = observer.payload();
        // What nobody could carry is a sensor's fault: it goes on with what it knew.
        let most = R::constant(0.3) * mass;
        let far = most * R::constant(0.5) * self.gains.height;
        if found.abs() < most && moment.iter().all(|x| x.abs() < far) {
            self.payload = Payload { mass: found, moment };
        }
    }
}
