"""A drive made with the library canopen: CiA 402, cyclic synchronous position, node 2.

Network management, heartbeat, PDO mapping and the bits of the status word are the library's; only
the steps of the state machine are written here. An ideal drive: at the SYNC it stands where it was
commanded. Runs inside the kernel until SIGTERM.
"""

import signal
import sys

import canopen
from canopen.objectdictionary import ODRecord, ODVariable, datatypes
from canopen.profiles.p402 import State402

NODE = 2
CONTROL, STATUS, TARGET, ACTUAL, OFFSET = 0x6040, 0x6041, 0x607A, 0x6064, 0x60B1
OBJECTS = {
    CONTROL: ("control word", datatypes.UNSIGNED16),
    STATUS: ("status word", datatypes.UNSIGNED16),
    TARGET: ("target position", datatypes.INTEGER32),
    ACTUAL: ("position actual value", datatypes.INTEGER32),
    OFFSET: ("velocity offset", datatypes.INTEGER32),
    0x1017: ("producer heartbeat time", datatypes.UNSIGNED16),
}
# Communication parameters: index, identifier, what is mapped.
PDOS = ((0x1400, 0x200 + NODE, (CONTROL, TARGET)), (0x1401, 0x300 + NODE, (OFFSET,)),
        (0x1800, 0x180 + NODE, (STATUS, ACTUAL)))  # fmt: skip
BITS = {datatypes.UNSIGNED8: 8, datatypes.UNSIGNED16: 16, datatypes.UNSIGNED32: 32}
BITS[datatypes.INTEGER32] = 32
HEARTBEAT_MS = 50

DISABLED, READY = "SWITCH ON DISABLED", "READY TO SWITCH ON"
SWITCHED_ON, ENABLED, FAULT = "SWITCHED ON", "OPERATION ENABLED", "FAULT"


def variable(name: str, index: int, sub: int, kind: int, value: int = 0) -> ODVariable:
    """Return an entry of the object dictionary."""
    entry = ODVariable(name, index, sub)
    entry.data_type, entry.default, entry.value, entry.access_type = kind, value, value, "rw"
    entry.pdo_mappable = True
    return entry


def record(name: str, index: int, values: list[tuple[int, int]]) -> ODRecord:
    """Return a record of numbers, each with its type, behind their count."""
    entry = ODRecord(name, index)
    entry.add_member(variable("count", index, 0, datatypes.UNSIGNED8, len(values)))
    for sub, (kind, value) in enumerate(values, 1):
        entry.add_member(variable(f"{name} {sub}", index, sub, kind, value))
    return entry


def dictionary() -> canopen.ObjectDictionary:
    """Return the objects of the drive with their PDOs."""
    od = canopen.ObjectDictionary()
    for index, (name, kind) in OBJECTS.items():
        od.add_object(variable(name, index, 0, kind))
    for index, cob_id, mapped in PDOS:
        numbers = [(datatypes.UNSIGNED32, cob_id), (datatypes.UNSIGNED8, 1)]
        od.add_object(record(f"PDO {index:x}", index, numbers))
        words = [(datatypes.UNSIGNED32, i << 16 | BITS[OBJECTS[i][1]]) for i in mapped]
        od.add_object(record(f"mapping {index:x}", index + 0x200, words))
    return od


def next_state(state: str, control_word: int) -> str:
    """Return the state after a control word, one step of the figure of CiA 402."""
    if state == FAULT:
        return DISABLED if control_word & 0x80 else FAULT
    if not control_word & 0x02 or not control_word & 0x04:
        return DISABLED
    if not control_word & 0x01:
        return READY
    up = {READY: SWITCHED_ON, SWITCHED_ON: ENABLED, ENABLED: ENABLED}
    if control_word & 0x08:
        return up.get(state, state)
    return SWITCHED_ON if state in up else state


class Drive:
    """The node on the bus."""

    def __init__(self) -> None:
        network = canopen.Network()
        heard = (0x000, 0x080, 0x200 + NODE, 0x300 + NODE)
        filters = [{"can_id": i, "can_mask": 0x7FF} for i in heard]
        network.connect(interface="socketcan", channel="vcan0", can_filters=filters)
        self.node = network.create_node(NODE, dictionary())
        self.node.rpdo.read(from_od=True)
        self.node.tpdo.read(from_od=True)
        for pdo in self.node.rpdo.values():
            network.subscribe(pdo.cob_id, pdo.on_message)
        network.subscribe(0x080, self.on_sync)
        self.state, self.position = DISABLED, 0
        self.network = network
        self.node.nmt.send_command(0x81)  # boot-up, pre-operational
        self.node.nmt.start_heartbeat(HEARTBEAT_MS)

    def on_sync(self, _id: int, _data: bytearray, _stamp: float) -> None:
        """Move to the target of the RPDO and send the status and the actual position."""
        if self.node.nmt.state != "OPERATIONAL":
            return
        self.state = next_state(self.state, self.node.rpdo[1][CONTROL].raw)
        if self.state == ENABLED:
            self.position = self.node.rpdo[1][TARGET].raw
        tpdo = self.node.tpdo[1]
        tpdo[STATUS].raw = State402.SW_MASK[self.state][1]
        tpdo[ACTUAL].raw = self.position
        tpdo.transmit()


def main() -> int:
    """Be a drive until a signal ends it."""
    drive = Drive()
    signal.sigwait({signal.SIGTERM, signal.SIGINT})
    drive.network.disconnect()
    return 0


if __name__ == "__main__":
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
    sys.exit(main())
