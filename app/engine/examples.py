"""Show fifteen short scripts of daily work: gains, filters, smoothing, faults and delays.

.. include:: examples.md
"""
