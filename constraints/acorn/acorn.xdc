# Pins and clocks of an Acorn CLE-215(+) or CLE-101, NiteFury or LiteFury, as PyPI's litex-boards 2023.12 has
# them, for Vivado. acorn.tcl reads this file. It has not been run yet, because the vendor's tools were not at
# hand. On the connector P2 any other assignment will do.
set_property INTERNAL_VREF 0.750 [get_iobanks 34]
set_property CFGBVS VCCO [current_design]
set_property CONFIG_VOLTAGE 3.3 [current_design]
set_property BITSTREAM.CONFIG.SPI_BUSWIDTH 4 [current_design]
set_property BITSTREAM.CONFIG.CONFIGRATE 16 [current_design]
set_property BITSTREAM.GENERAL.COMPRESS TRUE [current_design]

# --- Clocks. The vendor's block brings those of PCI Express itself. ---
create_clock -name clk200 -period 5.000 [get_ports clk200_p_i]
create_clock -name pcie_reference -period 10.000 [get_ports pcie_clk_p_i]

# Between the pixel clock and LitePCIe's clock: the bits of a Gray-coded pointer or a toggle may arrive at most one
# period of the sending clock apart; words that cross are stable for more than two periods (rtl/crossings.txt).
set pixel [get_clocks -of_objects [get_pins u_clk/O]]
set bus [get_clocks -of_objects [get_nets bus_clk]]
set_max_delay -datapath_only -from $pixel -to $bus 8.000
set_max_delay -datapath_only -from $bus -to $pixel 8.000
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *wr_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_wr_to_rd/meta_q_reg*}] 8.000
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *rd_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_rd_to_wr/meta_q_reg*}] 8.000
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *written_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_written_to_rd/meta_q_reg*}] 8.000

# What belongs to no clock
set_false_path -from [get_ports {encoder_a_i encoder_b_i pcie_rst_n_i}]
set_false_path -to [get_ports {led_o[*] projector_trigger_o camera_trigger_o pcie_clkreq_n_o}]

# --- Pins ---
set_property -dict {PACKAGE_PIN J19 IOSTANDARD DIFF_SSTL15} [get_ports clk200_p_i]
set_property -dict {PACKAGE_PIN H19 IOSTANDARD DIFF_SSTL15} [get_ports clk200_n_i]

set_property -dict {PACKAGE_PIN G3 IOSTANDARD LVCMOS33} [get_ports {led_o[0]}]
set_property -dict {PACKAGE_PIN H3 IOSTANDARD LVCMOS33} [get_ports {led_o[1]}]
set_property -dict {PACKAGE_PIN G4 IOSTANDARD LVCMOS33} [get_ports {led_o[2]}]
set_property -dict {PACKAGE_PIN H4 IOSTANDARD LVCMOS33} [get_ports {led_o[3]}]

set_property -dict {PACKAGE_PIN J1 IOSTANDARD LVCMOS33 PULLUP TRUE} [get_ports pcie_rst_n_i]
set_property -dict {PACKAGE_PIN G1 IOSTANDARD LVCMOS33} [get_ports pcie_clkreq_n_o]
set_property PACKAGE_PIN F6 [get_ports pcie_clk_p_i]
set_property PACKAGE_PIN E6 [get_ports pcie_clk_n_i]
set_property PACKAGE_PIN B10 [get_ports {pcie_rx_p_i[0]}]
set_property PACKAGE_PIN A10 [get_ports {pcie_rx_n_i[0]}]
set_property PACKAGE_PIN B8 [get_ports {pcie_rx_p_i[1]}]
set_property PACKAGE_PIN A8 [get_ports {pcie_rx_n_i[1]}]
set_property PACKAGE_PIN D11 [get_ports {pcie_rx_p_i[2]}]
set_property PACKAGE_PIN C11 [get_ports {pcie_rx_n_i[2]}]
set_property PACKAGE_PIN D9 [get_ports {pcie_rx_p_i[3]}]
set_property PACKAGE_PIN C9 [get_ports {pcie_rx_n_i[3]}]
set_property PACKAGE_PIN B6 [get_ports {pcie_tx_p_o[0]}]
set_property PACKAGE_PIN A6 [get_ports {pcie_tx_n_o[0]}]
set_property PACKAGE_PIN B4 [get_ports {pcie_tx_p_o[1]}]
set_property PACKAGE_PIN A4 [get_ports {pcie_tx_n_o[1]}]
set_property PACKAGE_PIN D5 [get_ports {pcie_tx_p_o[2]}]
set_property PACKAGE_PIN C5 [get_ports {pcie_tx_n_o[2]}]
set_property PACKAGE_PIN D7 [get_ports {pcie_tx_p_o[3]}]
set_property PACKAGE_PIN C7 [get_ports {pcie_tx_n_o[3]}]

# Connector P2
set_property -dict {PACKAGE_PIN K2 IOSTANDARD LVCMOS33 PULLUP TRUE} [get_ports encoder_a_i]
set_property -dict {PACKAGE_PIN J2 IOSTANDARD LVCMOS33 PULLUP TRUE} [get_ports encoder_b_i]
set_property -dict {PACKAGE_PIN J5 IOSTANDARD LVCMOS33} [get_ports projector_trigger_o]
set_property -dict {PACKAGE_PIN H5 IOSTANDARD LVCMOS33} [get_ports camera_trigger_o]
