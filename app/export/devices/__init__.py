"""Write a device's routine for boards, simulators and controllers."""
