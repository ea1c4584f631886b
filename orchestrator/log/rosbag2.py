"""Writes a log as the folder that `ros2 bag` opens."""

from __future__ import annotations

from pathlib import Path

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError

from crowdcosim.cdr import schema_text, type_hash
from orchestrator.errors import InputError
from orchestrator.log.reader import Log

_FOREVER = QosTime(9223372036, 854775807)


def _qos(latched: bool) -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=_FOREVER,
        lifespan=_FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOREVER,
        avoid_ros_namespace_conventions=False,
    )


def to_rosbag2(log: Log, folder: Path) -> None:
    """A new folder with an MCAP file and `metadata.yaml`, in the form of ROS 2 Jazzy and later.

    Raises:
        InputError: if the folder exists or cannot be written.
    """
    try:
        with Writer(folder, version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP) as writer:
            connections = {
                topic: writer.add_connection(
                    topic,
                    name,
                    msgdef=schema_text(name),
                    rihs01=type_hash(name),
                    offered_qos_profiles=[_qos(topic in log.latched)],
                )
                for topic, name in log.types.items()
            }
            for record in sorted(log.records, key=lambda record: record.time):
                writer.write(connections[record.topic], record.time, record.payload)
    except WriterError as error:
        raise InputError(f"cannot write {folder}: {error}; choose another --out, or remove it first") from None
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror}") from None
