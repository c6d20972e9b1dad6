//! The contacts given on the command line, at nodes or at positions along the plate.

use super::parse::{AskedContact, contact_at_node, contact_at_position};
use crate::commands::prelude::*;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use finray_model::sensing::{ContactQuestion, MeasuredContact};
use finray_model::sensor::{AskedDirection, SensorContacts};

const AT_NODES: &str = "contact";
const AT_POSITIONS: &str = "contact-at";

/// Values of `--contact` and `--contact-at` in the order in which they stand on the command line. Clap's derive macro keeps only the order within each
/// option.
pub struct Contacts(Vec<AskedContact>);

impl Contacts {
    /// Combines the contacts with the scene's friction and object. `friction` is the coefficient of friction for contacts with a standard deviation of
    /// position or direction; it confines their forces to a friction cone. `measured_deg` is the direction of the image's measured force, degrees.
    ///
    /// # Errors
    /// [`Failure::BadInput`] if the scene lacks the friction or object that a direction needs, or if only some contacts have standard deviations.
    pub fn of(&self, scene: &Scene, friction: f64, measured_deg: Option<f64>) -> Result<SensorContacts, Failure> {
        if self.0.iter().any(|asked| asked.has_deviation() && asked.measured().is_none()) {
            return Err(bad_input(
                "a contact with standard deviations (+-): expected numbers for its position and its direction",
            ));
        }
        let measured: Vec<MeasuredContact> = self.0.iter().filter_map(AskedContact::measured).collect();
        if !measured.is_empty() {
            return match measured.len() == self.0.len() {
                true => Ok(SensorContacts::Measured { contacts: measured, friction }),
                false => Err(bad_input("expected all contacts with standard deviations (+-), or none")),
            };
        }
        if friction > 0.0 {
            return Err(bad_input("--friction: expected contacts with standard deviations (+-)"));
        }
        let question = |asked: &AskedContact| {
            let direction = asked.direction.of_scene(scene, measured_deg).map_err(bad_input)?;
            Ok(ContactQuestion { position: asked.position, direction })
        };
        self.0.iter().map(question).collect::<Result<_, Failure>>().map(SensorContacts::Asked)
    }

    /// Whether any contact of unknown position is given without a direction; its force is then assumed along the undeformed normal.
    pub fn assume_normal(&self) -> bool {
        self.0.iter().any(|asked| asked.position.is_none() && !asked.is_direction_given)
    }

    /// Number of contacts.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Whether any contact has the direction `measured`.
    pub fn ask_measured(&self) -> bool {
        self.0.iter().any(|asked| asked.direction == AskedDirection::Measured)
    }
}

impl Args for Contacts {
    fn augment_args(command: Command) -> Command {
        let list = |name| Arg::new(name).long(name).num_args(1..).action(ArgAction::Append);
        command
            .arg(
                list(AT_NODES)
                    .value_name("NODE[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]")
                    .value_parser(contact_at_node)
                    .help("Contact at a node of the front plate, tip included"),
            )
            .arg(
                list(AT_POSITIONS)
                    .value_name("S_MM[+-SD]|auto[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]")
                    .value_parser(contact_at_position)
                    .help("Contact at a position along the front plate, mm from its base; auto: position unknown"),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Contacts::augment_args(command)
    }
}

impl FromArgMatches for Contacts {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Contacts, clap::Error> {
        let positions_and_values = |name| {
            let positions = matches.indices_of(name).into_iter().flatten();
            positions.zip(matches.get_many::<AskedContact>(name).into_iter().flatten().copied())
        };
        let mut contacts: Vec<_> = positions_and_values(AT_NODES).chain(positions_and_values(AT_POSITIONS)).collect();
        contacts.sort_by_key(|(position, _)| *position);
        Ok(Contacts(contacts.into_iter().map(|(_, contact)| contact).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Contacts::from_arg_matches(matches)?;
        Ok(())
    }
}
